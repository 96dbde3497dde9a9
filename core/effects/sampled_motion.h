#pragma once

#include <algorithm>
#include <utility>

#include "core/effects/smooth_velocity.h"
#include "core/math/types.h"

namespace hapton {

// The velocity of a device from its samples, which may lack a valid position, by the clock of their sender. Another sender may have another
// clock: where the time steps back, how long the hand took to its new place is unknown, and the motion begins anew at that place. Units: m,
// s, m/s. RT: yes. Threads: one.
class SampledMotion {
 public:
  // Adds the next sample. dt_s: time since the one before, 0 for the first; below 0: the clock has stepped back. Of a sample that is not
  // finite only the time counts.
  void add(const Vec3& p, double dt_s) noexcept {
    if (dt_s < 0.0) *this = {};
    since_valid_s_ += std::max(dt_s, 0.0);
    if (p.allFinite()) velocity_.add(p, std::exchange(since_valid_s_, 0.0));
  }

  const Vec3& velocity() const noexcept { return velocity_.mean(); }

 private:
  SmoothVelocity velocity_;
  double since_valid_s_ = 0.0;  // since the last sample that was finite
};

}  // namespace hapton
