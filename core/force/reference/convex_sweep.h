#pragma once

#include "core/geometry/closest_point.h"
#include "core/math/types.h"

namespace hapton {

// The first time at which a moving point is nearer to a triangle than `limit`.
struct SweepHit {
  double t = 1.0;          // share of the motion that is free, in [0, 1]
  bool hit = false;        // false: the motion is free up to `until`
  bool exhausted = false;  // the limit on iterations was reached; the motion is free up to t
};

// Follows p = from + t * motion, t in [0, until], and keeps its distance to the triangle at or above `limit`. The distance to a convex set
// is convex along a line, so Newton's tangent never overshoots while the distance falls: every step is certified by a distance alone, for
// faces, edges and vertices alike, without a discriminant that could cancel. Near an edge or vertex the direction is uncertain by rounding
// / distance, so a step is kept short compared with the distance.
// slop: how near to `limit` counts as reached. rounding: upper bound on the error of distances. Both in the unit of the coordinates.
// RT: yes. Source: conservative advancement, Mirtich (1996); we differ in using the exact slope, which makes it Newton's iteration.
SweepHit sweep_point(const PreparedTriangle& triangle, const Vec3& from, const Vec3& motion, double until, double limit, double slop,
                     double rounding) noexcept;

}  // namespace hapton
