#include "core/effects/smooth_velocity.h"

#include <algorithm>
#include <utility>

#include "core/effects/bounded_force.h"

namespace hapton {

void SmoothVelocity::add(const Vec3& p, double dt_s) noexcept {
  if (!p.allFinite() || (has_point_ && !(dt_s > 0.0))) return;
  const Vec3 moved = p - last_point_;
  last_point_ = p;
  if (!has_point_) {
    has_point_ = true;
    return;
  }
  const double interval_s = std::clamp(dt_s, kShortestS, kLongestS);
  if (!std::exchange(has_interval_, true)) intervals_s_.fill(interval_s);
  newest_ = (newest_ + 1) % kSamples;
  intervals_s_[newest_] = interval_s;
  interval_velocities_[newest_] = bounded_force(moved / dt_s, kMaxMPerS);
  update_mean();
}

void SmoothVelocity::shift(std::size_t count, const Vec3& velocity) noexcept {
  if (!velocity.allFinite()) return;
  for (std::size_t i = 0; i < std::min(count, kSamples); ++i) {
    Vec3& interval_velocity = interval_velocities_[(newest_ + kSamples - i) % kSamples];
    interval_velocity = bounded_force(interval_velocity - velocity, kMaxMPerS);
  }
  update_mean();
}

void SmoothVelocity::update_mean() noexcept {
  Vec3 distance_m = Vec3::Zero();
  double time_s = 0.0;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const std::size_t at = (newest_ + kSamples - i) % kSamples;
    const double weighted_s = static_cast<double>(kSamples - i) * intervals_s_[at];
    distance_m += weighted_s * interval_velocities_[at];
    time_s += weighted_s;
  }
  mean_ = distance_m / time_s;
}

}  // namespace hapton
