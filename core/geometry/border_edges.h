#pragma once

#include <cstddef>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The edges that only one triangle has, told apart.
struct BorderEdges {
  std::size_t open = 0;    // of a sheet or a hole: nothing goes on beyond
  std::size_t cracks = 0;  // the surface goes on across a gap: another border runs along it
};

// A border edge is a crack when each of three points along it has another border edge within `width`, and within a twentieth of its own
// length, so that the next edge of the same border is none. Vertices are taken as welded already; triangles that repeat one have no edges.
// Linear in the borders' length over `width` or their mean edge. Units: those of the mesh. RT: set-up only.
BorderEdges count_border_edges(const TriangleMesh& mesh, double width);

}  // namespace hapton
