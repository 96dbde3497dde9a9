#pragma once

#include <cstddef>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Closed bodies of a mesh: pieces that share no vertex, each of whose edges is run as often one way as the other.
struct ClosedBodies {
  std::size_t count = 0;
  std::size_t inside_out = 0;  // with their fronts inside; a cavity, which lies in the box of a body with its front outside, is none
};

// Vertices are taken as welded already. Time: linear in the mesh, but for the square of its cavities. RT: set-up only.
ClosedBodies count_closed_bodies(const TriangleMesh& mesh);

}  // namespace hapton
