#pragma once

#include <cstdint>

#include "devices/device.h"

namespace hapton {

// How long the motors go on after the last force that is good; how long coming back takes; and by when a force that must go has gone.
constexpr std::int64_t kSilenceLimitNs = 20'000'000;
constexpr std::int64_t kRampNs = 100'000'000;
constexpr std::int64_t kLongestReleaseNs = kSilenceLimitNs / 2;

// Where a device does not say: no hand moves a stylus so fast.
constexpr double kFastestHandMPerS = 5.0;

// What a device is held to: its own limits, as far as they make sense, which can only become tighter.
//   a device whose force or slew makes no sense (not between 1e-9 and 1e9) gets no force at all, one without torque no torque
//   a device too slow to let go within kLongestReleaseNs gets the slew that does
//   an axis of the workspace that is empty or not finite has no end; one without max_speed gets kFastestHandMPerS
// RT: tighten yes; making one is set-up only.
class SafetyLimits {
 public:
  explicit SafetyLimits(const DeviceLimits& device);

  // Takes the smaller of the present and the given, field by field, and of the workspaces what both have in common (where there is any).
  // What makes no sense changes nothing; nor do max_stiffness and peak_s, which limit nothing by themselves.
  void tighten(const DeviceLimits& wanted) noexcept;

  // From now on no force and no torque at all. RT: yes.
  void forbid_force() noexcept;

  const DeviceLimits& now() const noexcept { return now_; }
  // The device's own, whatever has been tightened: letting go is never slowed down, and what it can bear is no matter of taste.
  const DeviceLimits& device() const noexcept { return device_; }
  double release_n_per_s() const noexcept { return device_.max_slew_n_per_s; }
  double release_nm_per_s() const noexcept { return device_.max_torque_slew_nm_per_s; }

 private:
  DeviceLimits device_;
  DeviceLimits now_;
};

}  // namespace hapton
