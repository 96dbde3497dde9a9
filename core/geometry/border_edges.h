#pragma once

#include <cstddef>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The edges that only one triangle has, told apart.
struct BorderEdges {
  std::size_t open = 0;    // of a sheet or a hole: nothing goes on beyond
  std::size_t cracks = 0;  // the surface goes on across a gap: another border runs along it
  std::size_t work = 0;    // boxes and points that were looked at: what the time is proportional to
};

// A border edge is a crack when each of three points along it has another border edge within `width`, and within a twentieth of its own
// length, so that the next edge of the same border is none. Vertices are taken as welded already; triangles that repeat one have no edges.
//
// Time: n log n in the border edges of a surface, at most n^(4/3) where they lie in space at random, however long they are and however
// many lie together. A point that hundreds of edges pass by without coming within its own bounds is taken to have none.
// Units: those of the mesh. RT: set-up only.
BorderEdges count_border_edges(const TriangleMesh& mesh, double width);

}  // namespace hapton
