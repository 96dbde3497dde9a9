#pragma once

#include <cstddef>
#include <string>

#include "core/geometry/shaded_mesh.h"

namespace hapton {

struct NormalFanReport {
  std::size_t edge_fans = 0;     // degenerate triangles of two different points
  std::size_t corner_fans = 0;   // degenerate triangles of one point
  std::size_t open_corners = 0;  // vertices whose normals form no ring (on a boundary): no corner fans there
  std::string describe() const;
};

// Adds the two degenerate triangles ("fake triangles") of the FDH paper, fig. 1, along every edge whose two triangles have different
// normals at either end: between the edge seen from one side and the edge seen from the other, so that the normal turns continuously from
// one face's to the other's. We differ in one addition: where three or more normals meet in a vertex (a box's corner) the paper's triangles
// leave a gap without force; degenerate triangles of a single point fill it. On return triangles [0, faces) are the faces, then come the
// edge fans, then the corner fans. RT: set-up only.
NormalFanReport add_normal_fans(ShadedMesh& mesh);

}  // namespace hapton
