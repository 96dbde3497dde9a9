#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Boundary edges that hang together by their ends: the rim of a sheet, or of an opening in a surface.
struct BoundaryLoop {
  std::size_t edges = 0;
  double length = 0.0;          // of all edges
  double area = 0.0;            // norm of the vector area that the loop spans; right for a plane loop, less for others
  double piece_area = 0.0;      // of the surface that it bounds: all triangles that hang together by their vertices
  Vec3 centre = Vec3::Zero();   // mean of the edges, weighted by length
  Vec3 on_edge = Vec3::Zero();  // middle of its longest edge

  // The diameter of a round opening, twice the width of a narrow one: no ball that is wider goes through.
  double width() const { return length > 0.0 ? 4.0 * area / length : 0.0; }
  // An opening in a surface that goes on around it, and not the rim of a sheet: a flat sheet is as large as its rim spans, a hemisphere
  // twice, a cube without a lid five times.
  bool is_opening() const { return area < kOpeningShare * piece_area; }
  static constexpr double kOpeningShare = 0.3;
};

// The loops of all edges with one triangle, the widest first. Loops that meet in a vertex count as one. Triangles that repeat a vertex have
// no edges. Vertices must be welded already. Units: those of the mesh. Time: n log n. RT: set-up only.
std::vector<BoundaryLoop> find_boundary_loops(const TriangleMesh& mesh);

// The middles of the edges that two triangles traverse in the same direction: one of the two is flipped. In no special order. RT: set-up
// only.
std::vector<Vec3> find_inconsistent_edges(const TriangleMesh& mesh);

}  // namespace hapton
