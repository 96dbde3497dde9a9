#pragma once

#include <cmath>
#include <cstdint>

namespace hapton {

// Measures, along one axis, how much energy the device has taken from the hand and not given back: of the force that was on the motors
// times the motion it was on for, plus what the device's own damping turned to heat.
//
//   E += -(mean force since the last sample) (motion since then) + b (motion)^2 / (time)
//
// E >= 0: up to now the port is passive. Both terms are exact for the motion between two samples when the force did not change meanwhile;
// where it did, its mean in time stands for it. The energy that may be saved up is bounded: what was dissipated long ago must not hide a
// source that becomes active now. Source: B. Hannaford and J.-H. Ryu, "Time-domain passivity control of haptic interfaces", IEEE Trans.
// Robotics and Automation 18 (2002). Units J, N, m, s. RT: yes.
class PassivityObserver {
 public:
  struct Options {
    double device_damping_ns_per_m = 0.0;  // that is certain to be there; 0: none is counted on
    double most_saved_j = 0.01;
  };

  explicit PassivityObserver(const Options& options) : options_(options) {}

  // The force was on the motors for this long.
  void held(double force_n, double passed_s) noexcept {
    force_n_s_ += force_n * passed_s;
    passed_s_ += passed_s;
  }

  // A sample: the device point is here now. The first one begins. A position that is not finite is ignored.
  void observe(double position_m) noexcept {
    if (!std::isfinite(position_m)) return;
    moved_m_ = has_begun_ ? position_m - position_m_ : 0.0;
    position_m_ = position_m;
    has_begun_ = true;
    period_s_ = passed_s_;
    if (passed_s_ > 0.0) {
      energy_j_ += (options_.device_damping_ns_per_m * moved_m_ - force_n_s_) * moved_m_ / passed_s_;
      energy_j_ = std::fmin(energy_j_, options_.most_saved_j);
    }
    force_n_s_ = passed_s_ = 0.0;
  }

  // Below zero: the device has given energy that it never took.
  double energy_j() const noexcept { return energy_j_; }
  // Over the last period.
  double velocity_m_per_s() const noexcept { return period_s_ > 0.0 ? moved_m_ / period_s_ : 0.0; }
  double period_s() const noexcept { return period_s_; }

 private:
  Options options_;
  double energy_j_ = 0.0;
  double position_m_ = 0.0;
  double moved_m_ = 0.0;
  double force_n_s_ = 0.0;
  double passed_s_ = 0.0;
  double period_s_ = 0.0;
  bool has_begun_ = false;
};

}  // namespace hapton
