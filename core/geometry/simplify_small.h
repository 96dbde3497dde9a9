#pragma once

#include <cstddef>
#include <string>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

struct SimplifyReport {
  std::size_t before = 0;  // triangles before
  std::size_t after = 0;   // triangles after
  double bound_m = 0.0;    // the requested bound
  double error_m = 0.0;    // largest distance of a removed vertex from the new surface
  std::string describe() const;
};

// Merges triangles that are too small to matter, such that no vertex of the original mesh is then farther than max_error_m from the surface
// (0: does nothing). Boundaries do not move; the list of vertices stays the same; authored normals are removed. meshoptimizer chooses by
// quadrics, whose error is a mean over planes and not a bound. So the result is measured, and the simplification repeated with a smaller
// error until the bound holds; if it does not after 16 attempts, the triangles stay as they were. The measurement descends from triangle to
// triangle, so it may be too large but never too small. Pre: welded vertices. Error: max_error_m is neither 0 nor between 0 and the longest
// side of the mesh. RT: set-up only. Source: FDH paper, 4.1 and its reference 5; quadric error (Garland & Heckbert 1997) by meshoptimizer.
Result<SimplifyReport> simplify_small(TriangleMesh& mesh, double max_error_m);

}  // namespace hapton
