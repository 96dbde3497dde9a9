#pragma once

#include <cstddef>
#include <string>

#include "core/geometry/shaded_mesh.h"

namespace hapton {

struct SplitReport {
  double longest_edge = 0.0;  // of what was asked for, metres
  std::size_t edges = 0;      // halved, those of earlier rounds' halves included
  std::size_t triangles = 0;  // how many more there are now
  bool complete = true;       // false: the limit on triangles was reached first
  std::string describe() const;
};

// Halves edges longer than longest_edge, longest rounds first, until none is or the triangles reach max_triangles. An edge is halved in
// every triangle that shares it, so no crack and no T-junction opens; new points lie on the old triangles, and their normals are the
// means of the edge's ends, apart on both sides of a sharp edge.
// RT: set-up only. Source: fdh-rendering.txt, 4.1: "split large triangles".
SplitReport split_large(ShadedMesh& mesh, double longest_edge, std::size_t max_triangles);

}  // namespace hapton
