#pragma once

#include "safety/safety_limits.h"

namespace hapton {

// Thermal model of the motors: a winding with one time constant T, heated by force²,
//
//   T heat' = force² - heat,   load = heat / continuous²,   load 1: the steady state at continuous_force_n
//
// T follows from how long a cold device may apply max_force_n: 1 = (max / continuous)² (1 - exp(-peak_s / T)). From load kFadeFrom
// on the square of the force limit decreases linearly from max² to continuous² at load 1: so load stays below 1 and the force never
// jumps. Of a gap between two calls of note_applied no more than kLongestHeldS counts: by then every device has released its force, or
// sleeps with the machine. A device that can apply max_force_n continuously, or does not state for how long, has no budget. RT:
// note_applied and allowed_n yes; construction is set-up only.
class ThermalBudget {
 public:
  static constexpr double kFadeFrom = 0.8;      // a choice: larger holds the maximum longer, and fades faster
  static constexpr double kLongestHeldS = 1.0;  // any device has released its force by then: kCommandTimeoutNs is 20 ms
  static constexpr double kFaultLoad = 1.02;    // a load above what the fade allows: force was applied while note_applied was not called

  explicit ThermalBudget(const DeviceLimits& device);

  // force_n was on the motors for passed_s.
  void note_applied(const Vec3& force_n, double passed_s) noexcept;
  // Sets load 1, the largest that the fade permits: how warm the motors are is not known.
  void assume_hot(const DeviceLimits& limits) noexcept { heat_n2_ = limits.continuous_force_n * limits.continuous_force_n; }
  double allowed_n(const DeviceLimits& limits) const noexcept;

  double load(const DeviceLimits& limits) const noexcept {
    return time_constant_s_ == 0.0 ? 0.0 : heat_n2_ / (limits.continuous_force_n * limits.continuous_force_n);
  }
  // T in the formula, s; 0: no budget.
  double time_constant_s() const noexcept { return time_constant_s_; }

 private:
  double time_constant_s_ = 0.0;
  double heat_n2_ = 0.0;  // load x continuous²
};

}  // namespace hapton
