#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/math/types.h"

namespace hapton {

// What the hardware bears, whatever the others ask of it. SI units, frame W.
struct DeviceLimits {
  double max_force_n = 0.0;             // norm of the force the motors can hold
  double max_slew_n_per_s = 0.0;        // fastest change of force that the mechanics can pass on
  double max_stiffness_n_per_m = 0.0;   // a hint: stiffer walls buzz
  Vec3 workspace_min_m = Vec3::Zero();  // axis-aligned box the device point stays in
  Vec3 workspace_max_m = Vec3::Zero();
};

// The device at one instant. p_WD: device point in W (m), q_WT: stylus in W, buttons: one bit each, lowest first.
struct DeviceSample {
  std::int64_t time_ns = 0;
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  std::uint32_t buttons = 0;
};

enum class DeviceStatus : std::uint8_t {
  ready,
  ended,  // a recording has been played to its end
  fault,  // the hardware stopped answering: it takes no force any more
};

// A force-feedback device: 6 DOF in, 3 DOF out. One thread owns it; now_ns never goes back.
// RT: read, write, status and limits yes (bounded, no heap, lock, log or throw); making one is set-up only.
class Device {
 public:
  virtual ~Device() = default;
  virtual std::string_view name() const noexcept = 0;
  virtual const DeviceLimits& limits() const noexcept = 0;

  // The device at now_ns.
  virtual DeviceSample read(std::int64_t now_ns) noexcept = 0;

  // Puts force_n (N, frame W) on the motors from now_ns on, until the next write. Must be finite and within the limits.
  virtual void write(const Vec3& force_n, std::int64_t now_ns) noexcept = 0;

  virtual DeviceStatus status() const noexcept = 0;

  // Leads the simulated hand to p_WH, or lets it go its own way again; false: a real hand or a recording moves this device.
  virtual bool lead_hand(const std::optional<Vec3>& p_WH) noexcept = 0;
};

}  // namespace hapton
