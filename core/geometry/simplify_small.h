#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

struct SimplifyReport {
  std::size_t before = 0;
  std::size_t after = 0;
  double error_m = 0.0;  // how far the surface moved at most, by the quadrics' estimate
  std::string describe() const;
};

// Merges triangles that are too small to matter, as long as the surface moves by no more than max_error (a share of the mesh's longest
// side; 0: nothing is done). Open borders stay where they are.
// Pre: welded vertices. Error: max_error is not in 0 .. 1.
// RT: set-up only. Source: fdh-rendering.txt, 4.1 and its [5]; quadric error (Garland & Heckbert 1997) by meshoptimizer.
Result<SimplifyReport> simplify_small(TriangleMesh& mesh, double max_error);

}  // namespace hapton
