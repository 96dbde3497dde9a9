#include "core/force/contact_qp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/exact_cross.h"

namespace hapton {
namespace {

constexpr double kUnitRounding = 0x1p-52;

// A trial active set: the point where its planes hold with equality, nearest to the goal.
struct Trial {
  Vec3 y = Vec3::Zero();
  std::array<double, 3> push = {0, 0, 0};  // multipliers
  bool valid = false;
};

Trial on_one(const Vec3& goal, const ContactPlane& a) {
  const double push = a.height - a.normal.dot(goal);
  return {goal + push * a.normal, {push, 0, 0}, push >= 0.0};
}

// On the line of two planes: the goal's part along the line, plus the line's point nearest to zero. No large numbers cancel even
// where the planes are nearly parallel.
Trial on_two(const Vec3& goal, const ContactPlane& a, const ContactPlane& b) {
  const Vec3 line = accurate_cross(a.normal, b.normal);
  const double sine_squared = line.squaredNorm();
  if (!(sine_squared > 16.0 * kUnitRounding * kUnitRounding)) return {};  // parallel as far as rounding can tell
  const Vec3 y = (line * line.dot(goal) + a.height * b.normal.cross(line) + b.height * line.cross(a.normal)) / sine_squared;
  const Vec3 pushed = y - goal;  // = push_a * a.normal + push_b * b.normal
  const double push_a = b.normal.cross(line).dot(pushed) / sine_squared;
  const double push_b = line.cross(a.normal).dot(pushed) / sine_squared;
  return {y, {push_a, push_b, 0}, push_a >= 0.0 && push_b >= 0.0};
}

Trial on_three(const Vec3& goal, const ContactPlane& a, const ContactPlane& b, const ContactPlane& c) {
  const Vec3 bc = accurate_cross(b.normal, c.normal);
  const Vec3 ca = accurate_cross(c.normal, a.normal);
  const Vec3 ab = accurate_cross(a.normal, b.normal);
  const double det = a.normal.dot(bc);
  if (!(std::fabs(det) > 16.0 * kUnitRounding)) return {};
  const Vec3 y = (a.height * bc + b.height * ca + c.height * ab) / det;
  const Vec3 pushed = y - goal;
  Trial trial{y, {bc.dot(pushed) / det, ca.dot(pushed) / det, ab.dot(pushed) / det}, false};
  trial.valid = trial.push[0] >= 0.0 && trial.push[1] >= 0.0 && trial.push[2] >= 0.0;
  return trial;
}

}  // namespace

ConstrainedMotion constrain_motion(const Vec3& goal, std::span<const ContactPlane> planes) noexcept {
  ConstrainedMotion result;
  result.motion = goal;
  double scale = goal.norm();
  for (const ContactPlane& plane : planes) scale = std::max(scale, std::fabs(plane.height));
  const double tolerance = 32.0 * kUnitRounding * scale;  // rounding of one plane's value

  const auto slack = [&](int i, const Vec3& y) { return planes[i].normal.dot(y) - planes[i].height; };
  // Each round the optimum moves away from the goal through a new active set; repeats can only come from rounding.
  const int rounds = 8 + 4 * static_cast<int>(planes.size());
  for (int round = 0; round < rounds; ++round) {
    int worst = -1;
    double worst_slack = -tolerance;
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
      for (int k = 0; k < n; ++k) {
        if (slack(old[k], trial.y) < -tolerance) return;
      }
      const double distance = (trial.y - goal).squaredNorm();
      if (distance >= best_distance) return;
      best_distance = distance;
      best.motion = trial.y;
      best.active = set;
      best.push = trial.push;
      best.active_count = count;
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
