#pragma once

#include <cstddef>
#include <string>

#include "core/geometry/shaded_mesh.h"

namespace hapton {

struct NormalFanReport {
  std::size_t edge_fans = 0;     // degenerate triangles at two different points
  std::size_t corner_fans = 0;   // degenerate triangles at one point
  std::size_t open_corners = 0;  // vertices at which some normals form no ring (on a boundary): no corner fans between these
  std::string describe() const;
};

// Adds the degenerate triangles ("fake triangles") of the FDH paper, fig. 1: along every edge of two consistently oriented triangles, one
// for each end at which their normals differ, between the edge as seen from one side and the edge as seen from the other, so that the
// normal turns continuously from one face to the other. We differ in one addition: where three or more normals meet in a vertex (the corner
// of a box) the triangles of the paper leave a gap without force; degenerate triangles at a single point fill it. On return the triangles
// that were there before come first, then the edge fans, then the corner fans. RT: set-up only.
NormalFanReport add_normal_fans(ShadedMesh& mesh);

}  // namespace hapton
