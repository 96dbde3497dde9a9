#pragma once

#include <cstddef>
#include <string>

#include "core/geometry/shaded_mesh.h"

namespace hapton {

struct SplitReport {
  double longest_edge = 0.0;  // the requested one, metres
  std::size_t edges = 0;      // edges halved, including halves from earlier rounds
  std::size_t triangles = 0;  // triangles added
  bool complete = true;       // false: the limit on triangles was reached first
  std::string describe() const;
};

// Halves edges longer than longest_edge (0: none), in rounds that halve each of them once, until none is left or another round would make
// more than max_triangles. An edge is halved in every triangle that shares it, so no crack and no T-junction opens; new points lie on the
// old triangles, and their normals are the means of those at the ends of the edge, separately on both sides of a sharp edge. RT: set-up
// only. Source: FDH paper, 4.1: "split large triangles".
SplitReport split_large(ShadedMesh& mesh, double longest_edge, std::size_t max_triangles);

}  // namespace hapton
