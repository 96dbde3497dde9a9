#pragma once

#include <array>
#include <cstddef>

#include "core/math/types.h"

namespace hapton {

// The velocity of a point from its samples: weighted displacements of the last kSamples intervals over their weighted times. Weights fall
// linearly from the newest interval to zero. At equal intervals this is the weighted mean of the differences.
//
// Why these weights: for samples at equal intervals the sum of v_k . (mean at k) is never negative for any motion, because the real part of
// the filter's frequency response is half a Fejer kernel plus a constant. So a damper on this velocity never gives energy. The memory ends
// after kSamples: two objects with the same last samples agree to the last bit. The mean lags the newest difference by (kSamples - 1) / 3
// samples, and reduces the noise of single differences to 0.40 of its value. Intervals of different length: displacement and time are
// averaged separately, so a long interval counts more. Then the sum (of v_k dt_k . mean) is not negative as long as no interval is more
// than 16 times another (found by a search over orders of long and short ones). Beyond 16 times a damper b can give energy: at most 6 % of
// b v^2 dt where intervals differ a hundredfold, and at most 12 % for any intervals. With the mean of the single differences it would be 13
// times b v^2 dt, and the noise of a sample 0.1 ms after a late one would count ten times. For kSamples samples after a gap, the mean is
// about the velocity in the gap, then that of the new samples. Units: m, s, m/s. RT: yes. Threads: one.
class SmoothVelocity {
 public:
  static constexpr std::size_t kSamples = 8;

  void reset() noexcept { *this = {}; }

  // Adds the next sample. One that is not finite, or no later than the one before (dt_s not above 0), changes nothing; for the first, dt_s
  // does not count. The time before the first interval counts as rest, in intervals of the length of the first.
  void add(const Vec3& p, double dt_s) noexcept;

  // The frame has moved: the point of the last sample now has these coordinates.
  void move_last(const Vec3& p) noexcept {
    if (p.allFinite()) last_point_ = p;
  }

  // Subtracts `velocity` from the last `count` intervals: they were measured against something that moved with this velocity.
  void shift(std::size_t count, const Vec3& velocity) noexcept;

  // The smoothed velocity; zero before the second sample.
  const Vec3& mean() const noexcept { return mean_; }
  // The velocity over the last interval alone.
  Vec3 newest() const noexcept { return has_point_ ? interval_velocities_[newest_] : Vec3(Vec3::Zero()); }

 private:
  void update_mean() noexcept;

  // Far above the speed of any hand; keeps sums finite.
  static constexpr double kMaxMPerS = 1e6;
  // Limits of an interval's weight: below the clock's resolution, and beyond any pause in a motion. They keep sums finite as well.
  static constexpr double kShortestS = 1e-9;
  static constexpr double kLongestS = 1.0;

  std::array<Vec3, kSamples> interval_velocities_ = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(),
                                                     Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::array<double, kSamples> intervals_s_ = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};  // those of interval_velocities_
  std::size_t newest_ = 0;
  Vec3 mean_ = Vec3::Zero();
  Vec3 last_point_ = Vec3::Zero();
  bool has_point_ = false;
  bool has_interval_ = false;
};

}  // namespace hapton
