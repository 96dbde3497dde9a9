#include "safety/passivity_controller.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {

void PassivityController::note_applied(const Vec3& force_n, double passed_s) noexcept {
  force_n_s_ += passed_s * force_n;
  passed_s_ += passed_s;
}

void PassivityController::observe(double max_force_n, const Vec3& moved_m) noexcept {
  if (!(passed_s_ > 0.0)) return;
  period_s_ = passed_s_;
  const Vec3 force_before_n = std::exchange(mean_force_n_, force_n_s_ / passed_s_);
  const double hidden_j = 0.5 * device_.position_step_m * (mean_force_n_ - force_before_n).cwiseAbs().sum();
  mean_velocity_m_per_s_ = moved_m / passed_s_;
  force_n_s_ = Vec3::Zero();
  passed_s_ = 0.0;
  const double dissipated_j = take_dissipated_j(moved_m);
  if (mean_force_n_.isZero(0.0)) {
    given_j_ = std::max(0.0, given_j_);
    return;
  }
  given_j_ = std::max(given_j_ + mean_force_n_.dot(moved_m) + hidden_j - dissipated_j, -kMaxCreditM * max_force_n);
}

// Above 0 only at the end of a window. The integral of b v^2 over its time is at least b motion^2 / time.
double PassivityController::take_dissipated_j(const Vec3& moved_m) noexcept {
  window_moved_m_ += moved_m;
  window_s_ += period_s_;
  if (++window_samples_ < kWindow) return 0.0;
  const double distance_m = window_moved_m_.norm();
  const double dissipated_j = (device_.damping_ns_per_m * distance_m / window_s_ + device_.friction_n) * distance_m;
  window_moved_m_ = Vec3::Zero();
  window_s_ = 0.0;
  window_samples_ = 0;
  return dissipated_j;
}

// The root of f (v T + f T^2 / 2 m) = credit. v, the velocity now, is the mean velocity plus what the force has added since the middle of
// the period. The mass is at least mass_kg, and may be infinite: of the two, the one with the larger v counts, which allows less force.
double PassivityController::largest_allowed_n(const Vec3& direction) const noexcept {
  const double half_s = 0.5 * period_s_;
  const double gained_m_per_s = std::max(0.0, half_s * mean_force_n_.dot(direction) / device_.mass_kg);
  const double moved_m = period_s_ * (mean_velocity_m_per_s_.dot(direction) + gained_m_per_s);
  const double m_per_n = half_s * period_s_ / device_.mass_kg;
  const double credit_j = -given_j_;
  // If no force can take back the whole deficit, take back as much as one can.
  const double root = std::sqrt(std::max(0.0, moved_m * moved_m + 4.0 * m_per_n * credit_j));
  if (moved_m <= 0.0) return (root - moved_m) / (2.0 * m_per_n);
  return credit_j > 0.0 ? 2.0 * credit_j / (moved_m + root) : 0.0;  // this form of the root has no cancellation
}

Vec3 PassivityController::shape(const Vec3& wanted_n, double most_damping) noexcept {
  has_limited_ = false;
  if (!(period_s_ > 0.0)) return wanted_n;
  const double wanted_norm_n = wanted_n.norm();
  const double allowed_n = wanted_norm_n > 0.0 ? largest_allowed_n(wanted_n / wanted_norm_n) : 0.0;
  Vec3 force_n = wanted_n;
  if (allowed_n < wanted_norm_n) {
    force_n *= allowed_n / wanted_norm_n;
    has_limited_ = true;
  }
  const double squared_speed = mean_velocity_m_per_s_.squaredNorm();
  if (given_j_ > 0.0 && squared_speed > 0.0) {
    // The damping force is at most the one that stops the mass within the period.
    const double max_damping = std::min(most_damping, device_.mass_kg / period_s_);
    force_n -= std::min(max_damping, given_j_ / (period_s_ * squared_speed)) * mean_velocity_m_per_s_;
    has_limited_ = true;
  }
  return force_n;
}

}  // namespace hapton
