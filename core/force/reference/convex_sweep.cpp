#include "core/force/reference/convex_sweep.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// Limits the time, not the accuracy: Newton's iteration needs only a few rounds. SweepHit::exhausted tells whether the limit was reached.
constexpr int kMaxRounds = 400;
// At an edge or vertex a step is at most this many times the distance to the triangle, so that the error of the direction, which is
// rounding / distance, moves the point by at most this many times the rounding.
constexpr double kLongestStep = 256.0;

}  // namespace

SweepHit sweep_point(const PreparedTriangle& triangle, const Vec3& from, const Vec3& motion, double until, double limit, double slop,
                     double rounding) noexcept {
  double t = 0.0;
  for (int round = 0; round < kMaxRounds; ++round) {
    const ClosestPoint near = closest_point(triangle, from + t * motion);
    if (near.distance == 0.0 && near.feature != TriangleFeature::face) {  // only if the motion starts exactly on the triangle's boundary
      return triangle.normal.dot(motion) < 0.0 ? SweepHit{t, true, false} : SweepHit{until, false, false};
    }
    const double above = near.distance - limit;
    const double approach = -near.direction.dot(motion);
    if (near.feature == TriangleFeature::face) {
      if (approach <= 0.0) return {until, false, false};
      if (above <= slop) return {t, true, false};
      t += above / approach;
    } else {
      // The direction has no error along an edge, so only the part of the motion perpendicular to the edge counts.
      const double perpendicular = perpendicular_to(triangle, near.feature, motion).norm();
      const double doubt = perpendicular * rounding / near.distance;
      if (approach <= -doubt) return {until, false, false};
      if (above <= slop && approach > 0.0) return {t, true, false};
      double step = kLongestStep * near.distance / perpendicular;
      if (approach > 0.0) step = std::min(step, above / approach);
      t += step;
    }
    if (!(t < until)) return {until, false, false};
  }
  return {t, true, true};
}

}  // namespace hapton
