#include "core/force/reference/convex_sweep.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

constexpr int kMostRounds = 400;
// A step in the part of the motion across an edge is at most this many distances long, so that the direction's error, rounding / distance,
// moves the point by at most this many roundings.
constexpr double kLongestStride = 256.0;

// How fast the point moves across the feature; along an edge the direction is known exactly.
double speed_across(const PreparedTriangle& triangle, TriangleFeature feature, const Vec3& motion) {
  if (!is_edge(feature)) return motion.norm();
  const Vec3& edge = triangle.edge[static_cast<int>(feature) - static_cast<int>(TriangleFeature::edge0)];
  return (motion - (motion.dot(edge) / edge.squaredNorm()) * edge).norm();
}

}  // namespace

SweepHit sweep_point(const PreparedTriangle& triangle, const Vec3& from, const Vec3& motion, double until, double limit, double slack,
                     double rounding) noexcept {
  double t = 0.0;
  for (int round = 0; round < kMostRounds; ++round) {
    const ClosestPoint near = closest_point(triangle, from + t * motion);
    if (near.distance == 0.0 && near.feature != TriangleFeature::face) {  // only where a motion starts on the border itself
      return triangle.normal.dot(motion) < 0.0 ? SweepHit{t, true, false} : SweepHit{until, false, false};
    }
    const double above = near.distance - limit;
    const double approach = -near.direction.dot(motion);
    if (near.feature == TriangleFeature::face) {
      if (approach <= 0.0) return {until, false, false};
      if (above <= slack) return {t, true, false};
      t += above / approach;
    } else {
      const double across = speed_across(triangle, near.feature, motion);
      const double doubt = across * rounding / near.distance;
      if (approach <= -doubt) return {until, false, false};
      if (above <= slack && approach > 0.0) return {t, true, false};
      double step = kLongestStride * near.distance / across;
      if (approach > 0.0) step = std::min(step, above / approach);
      t += step;
    }
    if (!(t < until)) return {until, false, false};
  }
  return {t, true, true};
}

}  // namespace hapton
