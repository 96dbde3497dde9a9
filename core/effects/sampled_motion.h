#pragma once

#include <algorithm>
#include <utility>

#include "core/effects/smooth_velocity.h"
#include "core/math/types.h"

namespace hapton {

// The velocity of a device from its samples, some of which may have no place, by the clock of whoever sends them. Another sender may have
// another clock: where that steps back, how long the hand took to its new place is unknown, and the motion begins anew there. Units: m, s,
// m/s. RT: yes. Threads: one.
class SampledMotion {
 public:
  // The next sample. dt_s: since the one before, of the first 0; below 0, the clock has stepped back. One that is not finite takes its time
  // only.
  void add(const Vec3& p, double dt_s) noexcept {
    if (dt_s < 0.0) *this = {};
    unmoved_s_ += std::max(dt_s, 0.0);
    if (p.allFinite()) velocity_.add(p, std::exchange(unmoved_s_, 0.0));
  }

  const Vec3& velocity() const noexcept { return velocity_.mean(); }

 private:
  SmoothVelocity velocity_;
  double unmoved_s_ = 0.0;  // since the last sample that was finite
};

}  // namespace hapton
