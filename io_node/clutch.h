#pragma once

#include <algorithm>
#include <cstdint>

#include "devices/device.h"

namespace hapton {

// Indexing: while a button is held, the device point stands still for everybody but the safety governor, and there is no force, so that the
// hand can be moved back to where it has room. From the release on, the device point goes on from where it stood, moved by the displacement
// of the hand meanwhile. So the device point never jumps. The orientation always follows the hand.
//
// The force falls linearly to zero within kOutS of the press and rises within kBackS of the release, as the governor does for any pause: a
// stylus that is given free inside a body is not kicked. The governor comes after it, and sees where the device really is: its workspace,
// speed and energy are those of the hardware.
//
// Frame: W. Units: m, s. RT: all. Threads: one, but see DeviceLoop.
class Clutch {
 public:
  static constexpr double kOutS = 0.01;  // as the governor: kLongestReleaseNs, kRampNs (ramp_up.h)
  static constexpr double kBackS = 0.1;
  static constexpr double kLongestS =
      0.01;  // a longer time between two samples counts as this one: the force comes back slowly after a stall

  // button: a bit; 0: there is no clutch, and samples stay as they are to the last bit.
  explicit Clutch(std::uint32_t button = 0) noexcept : button_(button) {}

  // The sample as everybody else sees it. A position that is not finite stays.
  DeviceSample move(const DeviceSample& sample) noexcept {
    if (button_ == 0) return sample;
    DeviceSample moved = sample;
    const double since_s = last_ns_ == 0 ? 0.0 : 1e-9 * static_cast<double>(sample.time_ns - last_ns_);
    const double passed_s = std::clamp(since_s, 0.0, kLongestS);
    last_ns_ = sample.time_ns;
    share_ = std::clamp(share_ + (is_held_ ? -passed_s / kOutS : passed_s / kBackS), 0.0, 1.0);
    if (!sample.p_WD.allFinite()) return moved;
    const bool is_down = (sample.buttons & button_) != 0;
    if (is_held_) {
      offset_m_ = p_W_ - sample.p_WD;
    } else {
      p_W_ = sample.p_WD + offset_m_;
    }
    is_held_ = is_down;
    moved.p_WD = p_W_;
    return moved;
  }

  // Of every force and torque: 1 while the button is up.
  double share() const noexcept { return share_; }
  // From the device's own position to that of the sample.
  const Vec3& offset_m() const noexcept { return offset_m_; }
  bool is_held() const noexcept { return is_held_; }

 private:
  std::uint32_t button_;
  bool is_held_ = false;
  double share_ = 1.0;
  Vec3 p_W_ = Vec3::Zero();  // the last sample's
  Vec3 offset_m_ = Vec3::Zero();
  std::int64_t last_ns_ = 0;
};

}  // namespace hapton
