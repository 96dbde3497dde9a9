#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The edges with only one triangle, by kind.
struct BoundaryEdges {
  std::size_t open = 0;    // at the border of a sheet or a hole
  std::size_t cracks = 0;  // beside another boundary edge: the surface continues across a narrow gap
  // The widest gap, measured at a quarter, the middle and three quarters of each crack edge; an upper bound if many gaps differ.
  double widest_crack = 0.0;
  std::size_t work = 0;       // boxes and points examined; the time is proportional to it
  bool has_given_up = false;  // most_work was used up: some edges that count as open were not examined completely
};

// Largest work per boundary edge, on average: more than twice what any mesh of meshes/ needs after a cut along every edge (143).
// count_boundary_edges gives up beyond it, for example on 10,000 triangles that are each as large as the mesh.
constexpr std::size_t kMaxBoundaryWork = 320;

// Classifies boundary edges. An edge is a crack if each of three points along it has another boundary edge within `width` and within a
// twentieth of its own length, so that the next edge of the same boundary does not count. Vertices must be welded already; triangles that
// repeat a vertex have no edges.
//
// Time: n log n in the boundary edges of a surface; n^(4/3) if they lie in space at random, and no more than most_work for each edge. An
// edge with a point that hundreds of edges were compared to, none of them near, counts as open. Units: those of the mesh. RT: set-up only.
BoundaryEdges count_boundary_edges(const TriangleMesh& mesh, double width, std::size_t most_work = kMaxBoundaryWork);

// The same, with at_boundary from find_boundary_vertices (seam_mesh.h).
BoundaryEdges count_boundary_edges(const TriangleMesh& mesh, const std::vector<std::uint8_t>& at_boundary, double width,
                                   std::size_t most_work = kMaxBoundaryWork);

}  // namespace hapton
