#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The edges with only one triangle, by kind.
struct BoundaryEdges {
  std::size_t open = 0;    // of a sheet or a hole: nothing continues beyond
  std::size_t cracks = 0;  // another boundary runs alongside: the surface continues across a gap
  double widest_crack =
      0.0;               // gap at a quarter, the middle and three quarters of a crack's edges: the widest; an upper bound if many differ
  std::size_t work = 0;  // boxes and points examined; proportional to the time
  bool has_given_up = false;  // some edges counted as open were not examined completely, because too many lie across one another
};

// Per boundary edge, on average: more than twice what any mesh of meshes/ needs when it is torn apart at every edge (143).
// count_boundary_edges gives up beyond it: some 10,000 triangles as large as the mesh cause that.
constexpr std::size_t kMostBoundaryWork = 320;

// Classifies boundary edges. An edge is a crack if each of three points along it has another boundary edge within `width` and within a
// twentieth of its own length, so that the next edge of the same boundary does not count. Vertices must be welded already; triangles that
// repeat a vertex have no edges.
//
// Time: n log n in the boundary edges of a surface; n^(4/3) if they lie in space at random, and no more than most_work for each edge. A
// point that hundreds of edges pass without coming near counts as open. Units: those of the mesh. RT: set-up only.
BoundaryEdges count_boundary_edges(const TriangleMesh& mesh, double width, std::size_t most_work = kMostBoundaryWork);

// The same, with at_boundary from find_boundary_vertices (seam_mesh.h).
BoundaryEdges count_boundary_edges(const TriangleMesh& mesh, const std::vector<std::uint8_t>& at_boundary, double width,
                                   std::size_t most_work = kMostBoundaryWork);

}  // namespace hapton
