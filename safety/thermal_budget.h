#pragma once

#include "safety/safety_limits.h"

namespace hapton {

// What the motors have borne: the leaky integral of force² that a winding with one time constant T heats by,
//
//   T heat' = force² - heat,   load = heat / continuous²,   load 1: as hot as continuous_force_n makes them in the end
//
// T follows from how long the device bears max_force_n beginning cold: 1 = (max / continuous)² (1 - exp(-peak_s / T)). From load kFadeFrom
// on the force allowed² sinks linearly from max² to continuous², where it arrives at load 1: so load stays below 1 and the force never
// jumps. Nobody watches a gap in time: no more than kLongestHeldS of it counts, every device lets go by itself in less, or sleeps as the
// machine does. A device that bears its max_force_n without end, or does not say how long, has no budget.
// RT: held and allowed_n yes; making one is set-up only.
class ThermalBudget {
 public:
  static constexpr double kFadeFrom = 0.8;
  static constexpr double kLongestHeldS = 1.0;
  static constexpr double kSpent = 1.02;  // more than the fade lets through: force was held while nobody looked

  explicit ThermalBudget(const DeviceLimits& device);

  // force_n was on the motors for passed_s.
  void held(const Vec3& force_n, double passed_s) noexcept;
  double allowed_n(const DeviceLimits& limits) const noexcept;

  double load(const DeviceLimits& limits) const noexcept {
    return time_constant_s_ == 0.0 ? 0.0 : heat_n2_ / (limits.continuous_force_n * limits.continuous_force_n);
  }
  // T; 0: no budget.
  double time_constant_s() const noexcept { return time_constant_s_; }

 private:
  double time_constant_s_ = 0.0;
  double heat_n2_ = 0.0;  // load x continuous²
};

}  // namespace hapton
