#pragma once

#include <cstdint>

#include "devices/device.h"

namespace hapton {

// Age of its sample at which a force times out: five cycles at the lowest rate, 250 Hz. A longer age holds the force of a dead node longer;
// a shorter age removes forces that are merely late.
constexpr std::int64_t kCommandTimeoutNs = 20'000'000;
// Time within which a force must be released: one that is not replaced stays whole for half of the time until it has to be zero.
constexpr std::int64_t kLongestReleaseNs = kCommandTimeoutNs / 2;

// N, N/s, Nm and so on: a limit up to this is too small to divide by. A requested one forbids the force; one of a device is invalid.
constexpr double kMinUsableLimit = 1e-9;

// For a device without max_speed: faster than any hand moves a stylus.
constexpr double kFastestHandMPerS = 5.0;

// The limits that apply to a device: its own, if they are valid. They can only be tightened.
//   a device with an invalid force or slew limit (not between 1e-9 and 1e9) gets no force, one without torque limits no torque
//   a rate limit too low to release the force within kLongestReleaseNs is raised until it does
//   an axis of the workspace that is empty or not finite is unlimited; a device without max_speed gets kFastestHandMPerS
// RT: tighten yes; making one is set-up only.
class SafetyLimits {
 public:
  explicit SafetyLimits(const DeviceLimits& device);

  // Takes the smaller value of each field, and the intersection of the workspaces on each axis (if there is any). Invalid values have no
  // effect. max_stiffness and peak_s are ignored: neither limits a force by itself.
  void tighten(const DeviceLimits& wanted) noexcept;

  // No force and no torque from now on. RT: yes.
  void forbid_force() noexcept;
  // RT: yes.
  void forbid_torque() noexcept;

  const DeviceLimits& current() const noexcept { return current_; }
  // The device's own, before tightening: releasing a force is never slowed down, and the thermal model needs the device's true ratings.
  const DeviceLimits& device() const noexcept { return device_; }
  double release_n_per_s() const noexcept { return device_.max_slew_n_per_s; }
  double release_nm_per_s() const noexcept { return device_.max_torque_slew_nm_per_s; }

 private:
  DeviceLimits device_;
  DeviceLimits current_;
};

}  // namespace hapton
