#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Boundary edges that are connected by their ends: the border of a sheet, or of an opening in a surface.
struct BoundaryLoop {
  std::size_t edges = 0;
  double length = 0.0;          // sum over all edges
  double width = 0.0;           // diameter of the largest disc within its projection along the vector area (largest_disc)
  double area = 0.0;            // norm of the loop's vector area: the area of a plane loop, less for other loops
  double piece_area = 0.0;      // area of the piece that it bounds: all triangles that are connected by vertices
  Vec3 centre = Vec3::Zero();   // mean of the edges, weighted by length
  Vec3 on_edge = Vec3::Zero();  // middle of its longest edge

  // Whether this is an opening in a surface and not the border of a sheet. The area of the piece is that of the loop for a flat sheet,
  // twice that for a hemisphere, five times for a cube without a lid.
  bool is_opening() const { return area < kOpeningShare * piece_area; }
  static constexpr double kOpeningShare = 0.3;  // between a hemisphere (0.5) and a cube without a lid (0.2)
};

// The loops of all boundary edges (edges with one triangle), the widest first. Loops that share a vertex count as one. Triangles that
// repeat a vertex are ignored. negligible_width: for a loop that is not wider than this, `width` may be any bound of its width up to this.
// Pre: vertices are welded. Units: those of the mesh. Time: n log n, plus that of largest_disc. RT: set-up only.
std::vector<BoundaryLoop> find_boundary_loops(const TriangleMesh& mesh, double negligible_width = 0.0);

// The midpoints of all edges that two triangles traverse in the same direction: one of the two is flipped. In no particular order. RT:
// set-up only.
std::vector<Vec3> find_inconsistent_edges(const TriangleMesh& mesh);

}  // namespace hapton
