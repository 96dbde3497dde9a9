#pragma once

#include "core/geometry/closest_point.h"
#include "core/math/types.h"

namespace hapton {

// Where a moving point first comes as near to a triangle as `limit`.
struct SweepHit {
  double t = 1.0;          // the motion is free up to this share of it, in [0, until]
  bool hit = false;        // the point reaches the limit at t; false: t is `until`
  bool exhausted = false;  // the bound on iterations was reached at t, which counts as a hit: beyond t nothing is known
};

// Follows p = from + t * motion from t = 0 to where its distance to the triangle falls to `limit`, at most to `until`. The distance to a
// convex set is convex along a line, so Newton's tangent never overshoots while the distance falls: every step is certified by a distance
// alone, for faces, edges and vertices alike, without a discriminant that could cancel. Near an edge or vertex the error of the direction
// is rounding / distance, so a step there is at most 256 distances long. A motion that begins exactly on the triangle's boundary, where no
// direction is known, hits at once if it goes against the normal, and is free otherwise. slop: a distance of up to limit + slop counts as
// reached. rounding: upper bound on the error of distances. Both in the unit of the coordinates. Frame: any, one for all. RT: yes. Threads:
// any. Source: conservative advancement, Mirtich (1996); we use the exact slope instead of a bound, which makes it Newton's iteration.
SweepHit sweep_point(const PreparedTriangle& triangle, const Vec3& from, const Vec3& motion, double until, double limit, double slop,
                     double rounding) noexcept;

// The part of v that is perpendicular to the feature: all of it, except for an edge. RT: yes.
inline Vec3 perpendicular_to(const PreparedTriangle& triangle, TriangleFeature feature, const Vec3& v) noexcept {
  if (!is_edge(feature)) return v;
  const Vec3& edge = triangle.edge[edge_number(feature)];
  return v - (v.dot(edge) / edge.squaredNorm()) * edge;
}

}  // namespace hapton
