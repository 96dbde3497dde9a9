#pragma once

#include <algorithm>
#include <cstdint>

#include "devices/device.h"

namespace hapton {

// While a button is held, the device point stands still for everybody except the safety governor, and there is no force, so that the hand
// can be moved back to where it has room. After the release, the device point moves with the hand again, from the place where it stood: it
// is shifted by an offset and never jumps. The orientation always follows the hand.
//
// The force falls linearly to zero within kFadeOutS of the press and rises within kFadeInS of the release, as in the governor after any
// pause: a stylus whose clutch is released inside a body is not kicked. The governor acts after the clutch, and gets the device's real
// position: its limits of workspace, speed and energy are those of the hardware.
//
// Frame: W (world), with the device point D. Units: m, s. RT: yes. Threads: one at a time (the holder of DeviceLoop's claim).
class Clutch {
 public:
  static constexpr double kFadeOutS = 0.01;  // as in the governor: kLongestReleaseNs
  static constexpr double kFadeInS = 0.1;    // as in the governor: kRampNs (ramp_up.h)
  // A longer time between two samples counts as this, so that the force returns slowly after a stall.
  static constexpr double kLongestStepS = 0.01;

  // button: its bit in DeviceSample::buttons; 0: there is no clutch, and samples are not changed at all.
  explicit Clutch(std::uint32_t button = 0) noexcept : button_(button) {}

  // Returns the sample as all except the governor get it. A position that is not finite is not changed.
  DeviceSample move(const DeviceSample& sample) noexcept {
    if (button_ == 0) return sample;
    DeviceSample moved = sample;
    const double since_s = last_ns_ == 0 ? 0.0 : 1e-9 * static_cast<double>(sample.time_ns - last_ns_);
    const double passed_s = std::clamp(since_s, 0.0, kLongestStepS);
    last_ns_ = sample.time_ns;
    force_factor_ = std::clamp(force_factor_ + (is_held_ ? -passed_s / kFadeOutS : passed_s / kFadeInS), 0.0, 1.0);
    if (!sample.p_WD.allFinite()) return moved;
    const bool is_down = (sample.buttons & button_) != 0;
    if (is_held_) {
      offset_m_ = last_p_WD_ - sample.p_WD;
    } else {
      last_p_WD_ = sample.p_WD + offset_m_;
    }
    is_held_ = is_down;
    moved.p_WD = last_p_WD_;
    return moved;
  }

  // Factor of every force and torque: 0 to 1; 1 again kFadeInS after the release of the button.
  double force_factor() const noexcept { return force_factor_; }
  // Vector from the device's own position to the position that move() returned.
  const Vec3& offset_m() const noexcept { return offset_m_; }
  bool is_held() const noexcept { return is_held_; }

 private:
  std::uint32_t button_;
  bool is_held_ = false;
  double force_factor_ = 1.0;
  Vec3 last_p_WD_ = Vec3::Zero();  // position that move() returned last
  Vec3 offset_m_ = Vec3::Zero();
  std::int64_t last_ns_ = 0;
};

}  // namespace hapton
