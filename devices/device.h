#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/math/types.h"
#include "watchdog/heartbeat_page.h"

namespace hapton {

// Limits of the hardware. SI units, frame W.
struct DeviceLimits {
  double max_force_n = 0.0;             // norm of the largest force
  double max_slew_n_per_s = 0.0;        // fastest change of force that the mechanics transmit
  double max_stiffness_n_per_m = 0.0;   // stiffer walls vibrate; does not limit a force, but sets the governor's damping; 0: unknown
  Vec3 workspace_min_m = Vec3::Zero();  // axis-aligned box the device point stays in
  Vec3 workspace_max_m = Vec3::Zero();
  double max_torque_nm = 0.0;  // norm of the largest torque; 0: no motor turns the stylus
  double max_torque_slew_nm_per_s = 0.0;
  double continuous_force_n = 0.0;  // continuous rating of the motors; 0: max_force_n
  double peak_s = 0.0;              // how long cold motors may apply max_force_n; 0: unlimited
  double max_speed_m_per_s = 0.0;   // no hand is faster: above it an encoder is broken or the device out of control; 0: unknown
};

// The time from zero to the maximum force, for devices of which nothing more is known: half of a quarter period at 30 Hz, the lowest
// structural frequency of the PHANToM Model A. That is faster than the mechanics transmit a force.
inline constexpr double kForceRiseS = 0.004;

// Force and torque for the motors, frame W.
struct Wrench {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();
};

// The device at one instant. p_WD: device point in W (m), q_WT: orientation of the stylus in W, buttons: one bit each, lowest first.
// is_held: a hand holds the stylus; always true if the device cannot sense that.
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
  fault,        // the hardware has stopped responding: no more forces
  away,         // unplugged or not responding, being reconnected: reads repeat the last sample, forces have no effect
  calibrating,  // its position is not valid yet: forces have no effect
};

// What the hardware reports about itself, for people. Texts live as long as the device.
struct DeviceCondition {
  std::string_view model;
  std::string_view serial;
  std::string_view firmware;
  bool is_calibrated = true;
  double motor_temperature = -1.0;  // 0 cold .. 1 too hot; below 0: not known
};

// A force-feedback device: 6 DOF in, 3 or 6 DOF out. One thread owns it; now_ns never decreases.
// RT: read, write, status, condition and limits yes (bounded, no heap, lock, log or throw); making one is set-up only.
class Device {
 public:
  virtual ~Device() = default;
  // The name of this kind of device. Its first 15 bytes go to the haptics node (LoopFacts), which distinguishes kinds of devices by them.
  virtual std::string_view name() const noexcept = 0;
  virtual const DeviceLimits& limits() const noexcept = 0;

  // The state of the device at now_ns.
  virtual DeviceSample read(std::int64_t now_ns) noexcept = 0;

  // Puts a wrench (N, N m, frame W) on the motors from now_ns until the next write. Pre: the wrench is finite and within the limits.
  virtual void write(const Wrench& wrench, std::int64_t now_ns) noexcept = 0;

  // Cuts the device: until restore(), no force is on the motors, whatever is written, and Hapton's compensation of the device's weight is
  // off; a vendor's library may keep its own. It also works while another thread is inside write(). False: the device cannot do that.
  // RT: yes, wait-free. Threads: cut() any, at any time; restore() only the owner.
  virtual bool cut() noexcept { return false; }
  virtual void restore() noexcept {}

  // Set-up only, by the owner. The device writes into the page, and keeps up to date, how another process can release the force
  // (CutMeans in watchdog/heartbeat_page.h). If there is no way, io_node warns at its start, or ends with --watchdog require.
  virtual void use_heartbeat_page(HeartbeatPage& /*page*/) noexcept {}

  virtual DeviceStatus status() const noexcept = 0;
  virtual DeviceCondition condition() const noexcept { return {}; }

  // Moves the simulated hand to p_WH; without a target the hand returns to its script. False: a real hand or a recording moves the device.
  virtual bool set_hand_target(const std::optional<Vec3>& p_WH) noexcept = 0;

  // Buttons that the simulated hand holds down until the next call, one bit each, lowest first; 0: it is not led. False: as above. RT: yes.
  virtual bool press_hand_buttons(std::uint32_t /*buttons*/) noexcept { return false; }

  // How the simulated hand turns the stylus while it is led, in addition to the tilt of its script: yaw about y, then pitch about x, then
  // roll about the stylus, rad; the axes are those of the device's own base. The hand turns at the speed of an arm, and returns to zero by
  // at most half a turn about each axis. The caller sets zero when the lead ends. False: as set_hand_target. RT: yes.
  virtual bool turn_hand(const Vec3& /*turn_rad*/) noexcept { return false; }

  // The largest number of points in SceneFacts (SceneFacts::kMaxPoints).
  static constexpr std::size_t kMaxAims = 16;
  // Points of the scene's surface (W) that the simulated hand goes to, each time one at random; only the first kMaxAims are used. Without
  // points the hand searches for the scene by itself. False: as set_hand_target. RT: yes.
  virtual bool aim_hand(std::span<const Vec3> /*p_WA*/) noexcept { return false; }
};

}  // namespace hapton
