#pragma once

#include <cstddef>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The edges that only one triangle has, told apart.
struct BorderEdges {
  std::size_t open = 0;       // of a sheet or a hole: nothing goes on beyond
  std::size_t cracks = 0;     // the surface goes on across a gap: another border runs along it
  std::size_t work = 0;       // boxes and points that were looked at: what the time is proportional to
  bool has_given_up = false;  // some edges that count as open were not looked at to the end: they lie across one another without end
};

// For each border edge, on the average: more than twice what any mesh of meshes/ takes when it is torn apart at every edge (143).
// count_border_edges gives up beyond it: some 10,000 triangles as large as the mesh do.
constexpr std::size_t kMostBorderWork = 320;

// A border edge is a crack when each of three points along it has another border edge within `width`, and within a twentieth of its own
// length, so that the next edge of the same border is none. Vertices are taken as welded already; triangles that repeat one have no edges.
//
// Time: n log n in the border edges of a surface; n^(4/3) where they lie in space at random, and no more than most_work for each edge. A
// point that hundreds of edges pass by without coming within its own bounds is taken to have none.
// Units: those of the mesh. RT: set-up only.
BorderEdges count_border_edges(const TriangleMesh& mesh, double width, std::size_t most_work = kMostBorderWork);

}  // namespace hapton
