#include "core/effects/smooth_velocity.h"

#include <algorithm>

#include "core/effects/bounded_force.h"

namespace hapton {

void SmoothVelocity::add(const Vec3& p, double dt_s) noexcept {
  if (!p.allFinite() || (has_point_ && !(dt_s > 0.0))) return;
  const Vec3 moved = p - last_;
  last_ = p;
  if (!has_point_) {
    has_point_ = true;
    return;
  }
  newest_ = (newest_ + 1) % kSamples;
  differences_[newest_] = bounded_force(moved / dt_s, kMaxMPerS);
  update_mean();
}

void SmoothVelocity::shift(std::size_t count, const Vec3& velocity) noexcept {
  if (!velocity.allFinite()) return;
  for (std::size_t i = 0; i < std::min(count, kSamples); ++i) {
    Vec3& difference = differences_[(newest_ + kSamples - i) % kSamples];
    difference = bounded_force(difference - velocity, kMaxMPerS);
  }
  update_mean();
}

void SmoothVelocity::update_mean() noexcept {
  constexpr double kTotal = 0.5 * static_cast<double>(kSamples * (kSamples + 1));
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < kSamples; ++i) {
    sum += static_cast<double>(kSamples - i) * differences_[(newest_ + kSamples - i) % kSamples];
  }
  mean_ = sum / kTotal;
}

}  // namespace hapton
