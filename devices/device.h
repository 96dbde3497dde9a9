#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/math/types.h"
#include "watchdog/guard_page.h"

namespace hapton {

// What the hardware bears, whatever the others ask of it. SI units, frame W.
struct DeviceLimits {
  double max_force_n = 0.0;             // norm of the force the motors can hold
  double max_slew_n_per_s = 0.0;        // fastest change of force that the mechanics can pass on
  double max_stiffness_n_per_m = 0.0;   // a hint: stiffer walls buzz
  Vec3 workspace_min_m = Vec3::Zero();  // axis-aligned box the device point stays in
  Vec3 workspace_max_m = Vec3::Zero();
  double max_torque_nm = 0.0;  // norm; 0: no motor turns the stylus
  double max_torque_slew_nm_per_s = 0.0;
  double continuous_force_n = 0.0;  // what the motors bear without end; 0: max_force_n
  double peak_s = 0.0;              // how long max_force_n may last, beginning cold; 0: without end
  double max_speed_m_per_s = 0.0;   // faster is no hand: a broken encoder or a device out of control; 0: not known
};

// What goes to the motors, frame W.
struct Wrench {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();
};

// The device at one instant. p_WD: device point in W (m), q_WT: stylus in W, buttons: one bit each, lowest first. is_held: a hand holds
// the stylus, as far as the device can tell; a device that cannot says true.
struct DeviceSample {
  std::int64_t time_ns = 0;
  Vec3 p_WD = Vec3::Zero();
  Quat q_WT = Quat::Identity();
  std::uint32_t buttons = 0;
  bool is_held = true;
};

enum class DeviceStatus : std::uint8_t {
  ready,
  ended,        // a recording has been played to its end
  fault,        // the hardware stopped answering for good: it takes no force any more
  away,         // unplugged or silent, looked for all the while: reads repeat the last sample, forces go nowhere
  calibrating,  // its position is not to be trusted yet: forces go nowhere
};

// What the hardware says of itself, for people. Texts live as long as the device.
struct DeviceCondition {
  std::string_view model;
  std::string_view serial;
  std::string_view firmware;
  bool is_calibrated = true;
  double motor_temperature = -1.0;  // 0 cold .. 1 too hot; below 0: not known
};

// A force-feedback device: 6 DOF in, 3 or 6 DOF out. One thread owns it; now_ns never goes back.
// RT: read, write, status, condition and limits yes (bounded, no heap, lock, log or throw); making one is set-up only.
class Device {
 public:
  virtual ~Device() = default;
  virtual std::string_view name() const noexcept = 0;
  virtual const DeviceLimits& limits() const noexcept = 0;

  // The device at now_ns.
  virtual DeviceSample read(std::int64_t now_ns) noexcept = 0;

  // Puts a wrench (N, N m, frame W) on the motors from now_ns on, until the next write. Must be finite and within the limits.
  virtual void write(const Wrench& wrench, std::int64_t now_ns) noexcept = 0;

  // No force on the motors from now on, whatever write says, until restore; it needs nothing but the device, so it works while another
  // thread is within write. restore is the owner's. False: the device cannot do that.
  // RT: yes, wait-free. Threads: cut any, at any time.
  virtual bool cut() noexcept { return false; }
  virtual void restore() noexcept {}

  // Set-up only, by the owner: says in the page how another process takes the force away (watchdog/guard_page.h), and keeps that up to
  // date.
  virtual void use_guard(GuardPage& /*page*/) noexcept {}

  virtual DeviceStatus status() const noexcept = 0;
  virtual DeviceCondition condition() const noexcept { return {}; }

  // Leads the simulated hand to p_WH, or lets it go its own way again; false: a real hand or a recording moves this device.
  virtual bool lead_hand(const std::optional<Vec3>& p_WH) noexcept = 0;

  // Points of the scene's surface (W) that the simulated hand goes to, one after the other; the first kMostAims count. None: it looks for
  // itself. False: as above. RT: yes.
  static constexpr std::size_t kMostAims = 16;
  virtual bool aim_hand(std::span<const Vec3> /*p_WA*/) noexcept { return false; }
};

}  // namespace hapton
