#pragma once

#include "core/geometry/closest_point.h"
#include "core/math/types.h"

namespace hapton {

// When a moving point first comes nearer to a triangle than `limit`.
struct SweepHit {
  double t = 1.0;          // share of the motion that is free, in [0, 1]
  bool hit = false;        // false: the whole motion up to `until` is free
  bool exhausted = false;  // the bound on rounds was met; t is still free
};

// Follows p = from + t * motion, t in [0, until], and keeps its distance to the triangle at or above limit.
// The distance to a convex set is convex along a line, so Newton's tangent never overshoots a decreasing branch: every step is
// certified by a distance alone, for faces, edges and corners alike, with no discriminant to cancel. Near an edge or a corner the direction
// is uncertain by rounding / distance, so a step is kept short against the distance there.
// `slack`: how near to limit counts as reached. `rounding`: an upper bound on the error of distances. Both in the unit of the coordinates.
// RT: yes. Source: conservative advancement, Mirtich (1996); we differ in using the exact slope, which makes it Newton's iteration.
SweepHit sweep_point(const PreparedTriangle& triangle, const Vec3& from, const Vec3& motion, double until, double limit, double slack,
                     double rounding) noexcept;

}  // namespace hapton
