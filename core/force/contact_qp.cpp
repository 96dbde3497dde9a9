#include "core/force/contact_qp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/exact_cross.h"

namespace hapton {
namespace {

constexpr double kUnitRounding = 0x1p-52;

// A candidate: the point nearest to the goal at which all planes of a set hold with equality.
struct Trial {
  Vec3 y = Vec3::Zero();
  std::array<double, 3> multipliers = {0, 0, 0};  // of the planes of the set, in order
  bool valid = false;
};

Trial on_one(const Vec3& goal, const ContactPlane& a) {
  const double multiplier = a.height - a.normal.dot(goal);
  return {goal + multiplier * a.normal, {multiplier, 0, 0}, multiplier >= 0.0};
}

// If the sine of the angle between planes is below this, only a second, corrected solution finds their common point to the rounding of a
// plane's value: the terms of the first solution cancel down to a share of this size.
constexpr double kSmallSine = 0x1p-5;

// The goal's component along the common line of the planes, plus the point of that line nearest to the origin.
Trial on_two(const Vec3& goal, const ContactPlane& a, const ContactPlane& b) {
  const Vec3 line = accurate_cross(a.normal, b.normal);
  const double sine_squared = line.squaredNorm();
  if (!(sine_squared > 16.0 * kUnitRounding * kUnitRounding)) return {};  // parallel up to rounding
  const auto nearest_to = [&](double height_a, double height_b) {
    return Vec3((height_a * b.normal.cross(line) + height_b * line.cross(a.normal)) / sine_squared);
  };
  Vec3 y = line * (line.dot(goal) / sine_squared) + nearest_to(a.height, b.height);
  if (sine_squared < kSmallSine * kSmallSine) y += nearest_to(a.height - a.normal.dot(y), b.height - b.normal.dot(y));
  const Vec3 correction = y - goal;  // = multiplier_a * a.normal + multiplier_b * b.normal
  const double multiplier_a = b.normal.cross(line).dot(correction) / sine_squared;
  const double multiplier_b = line.cross(a.normal).dot(correction) / sine_squared;
  return {y, {multiplier_a, multiplier_b, 0}, multiplier_a >= 0.0 && multiplier_b >= 0.0};
}

Trial on_three(const Vec3& goal, const ContactPlane& a, const ContactPlane& b, const ContactPlane& c) {
  const Vec3 bc = accurate_cross(b.normal, c.normal);
  const Vec3 ca = accurate_cross(c.normal, a.normal);
  const Vec3 ab = accurate_cross(a.normal, b.normal);
  const double det = a.normal.dot(bc);
  if (!(std::fabs(det) > 16.0 * kUnitRounding)) return {};
  const auto meeting_at = [&](double height_a, double height_b, double height_c) {
    return Vec3((height_a * bc + height_b * ca + height_c * ab) / det);
  };
  Vec3 y = meeting_at(a.height, b.height, c.height);
  if (std::fabs(det) < kSmallSine) y += meeting_at(a.height - a.normal.dot(y), b.height - b.normal.dot(y), c.height - c.normal.dot(y));
  const Vec3 correction = y - goal;
  Trial trial{y, {bc.dot(correction) / det, ca.dot(correction) / det, ab.dot(correction) / det}, false};
  trial.valid = trial.multipliers[0] >= 0.0 && trial.multipliers[1] >= 0.0 && trial.multipliers[2] >= 0.0;
  return trial;
}

}  // namespace

ConstrainedMotion constrain_motion(const Vec3& goal, std::span<const ContactPlane> planes) noexcept {
  ConstrainedMotion result;
  result.motion = goal;
  double scale = goal.norm();
  for (const ContactPlane& plane : planes) scale = std::max(scale, std::fabs(plane.height));
  // Rounding error of one plane's value at y. Between nearly opposite planes y is far longer than the heights.
  const auto tolerance = [&](const Vec3& y) { return 32.0 * kUnitRounding * std::max(scale, y.cwiseAbs().maxCoeff()); };

  const auto slack = [&](int i, const Vec3& y) { return planes[i].normal.dot(y) - planes[i].height; };
  // Each round moves the optimum away from the goal to a new active set. Only rounding can repeat a set, so the bound ends the loop.
  const int rounds = 8 + 4 * static_cast<int>(planes.size());
  for (int round = 0; round < rounds; ++round) {
    int worst = -1;
    double worst_slack = -tolerance(result.motion);
    for (int i = 0; i < static_cast<int>(planes.size()); ++i) {
      const double s = slack(i, result.motion);
      if (s < worst_slack) {
        worst_slack = s;
        worst = i;
      }
    }
    if (worst < 0) return result;

    const std::array<int, 3> old = result.active;
    const int n = result.active_count;
    ConstrainedMotion best;
    double best_distance = std::numeric_limits<double>::infinity();
    const auto consider = [&](const Trial& trial, std::array<int, 3> set, int count) {
      if (!trial.valid) return;
      const double least = -tolerance(trial.y);
      for (int k = 0; k < n; ++k) {
        if (slack(old[k], trial.y) < least) return;
      }
      const double distance = (trial.y - goal).squaredNorm();
      if (distance >= best_distance) return;
      best_distance = distance;
      best = {trial.y, set, trial.multipliers, count};
    };
    const ContactPlane& w = planes[worst];
    consider(on_one(goal, w), {worst, -1, -1}, 1);
    for (int i = 0; i < n; ++i) consider(on_two(goal, w, planes[old[i]]), {worst, old[i], -1}, 2);
    for (int i = 0; i < n; ++i) {
      for (int j = i + 1; j < n; ++j) consider(on_three(goal, w, planes[old[i]], planes[old[j]]), {worst, old[i], old[j]}, 3);
    }
    if (best.active_count == 0) break;
    result = best;
  }
  result.motion = Vec3::Zero();
  result.solved = false;
  return result;
}

}  // namespace hapton
