#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/math/types.h"
#include "watchdog/heartbeat_page.h"

namespace hapton {

// Limits of the hardware. SI units, frame W (the world: docs/frames.md). The governor (safety/safety_governor.h) keeps every wrench within
// them, or within tighter limits, before a device gets it.
struct DeviceLimits {
  double max_force_n = 0.0;             // norm of the largest force
  double max_slew_n_per_s = 0.0;        // rate limit: the fastest change of the force vector that may be written
  double max_stiffness_n_per_m = 0.0;   // stiffer walls vibrate. It limits no force: the governor's damping follows from it. 0: unknown
  Vec3 workspace_min_m = Vec3::Zero();  // axis-aligned box the device point stays in
  Vec3 workspace_max_m = Vec3::Zero();
  double max_torque_nm = 0.0;             // norm of the largest torque; 0: no motor turns the stylus
  double max_torque_slew_nm_per_s = 0.0;  // rate limit of the torque
  double continuous_force_n = 0.0;        // continuous rating of the motors; 0: max_force_n
  double peak_s = 0.0;                    // how long cold motors may apply max_force_n; 0: unlimited
  double max_speed_m_per_s = 0.0;         // no hand is faster: above it an encoder is broken or the device out of control; 0: unknown
};

// If the rate limit of a device is not known, it is set so that the force rises from zero to its maximum in this time: half of a quarter
// period at 30 Hz, the lowest structural frequency of the PHANToM Model A. Its mechanics do not transmit a force faster than in a quarter
// period, so this rate limit changes no force that a hand could feel.
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

// A force-feedback device: 6 DOF in, 3 or 6 DOF out. now_ns is the time now of the caller's Clock (runtime/clock.h: ns of CLOCK_MONOTONIC,
// or simulated) and never decreases. RT: set-up only where a function says so, otherwise yes (bounded, no heap, lock, log or throw); making
// a device is set-up only. Threads: one owns the device.
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

  // The next four control a simulated hand. A device that a real hand or a recording moves has none: they return false and do nothing.
  //
  // A simulated hand has a script: by itself it searches for the scene, touches it and moves over it (devices/hand_script.h). While it has
  // a target, it is led: it moves to that target, and its script waits. Point H is where the hand moves to, A is a point of the scene.

  // Leads the simulated hand to p_WH (m). Without a target the hand is no longer led and returns to its script.
  virtual bool set_hand_target(const std::optional<Vec3>& p_WH) noexcept = 0;

  // Buttons that the simulated hand holds down until the next call, one bit each, lowest first. The caller sets 0 when the hand is no
  // longer led.
  virtual bool press_hand_buttons(std::uint32_t /*buttons*/) noexcept { return false; }

  // How a led hand turns the stylus, in addition to the tilt of its script: yaw about y, then pitch about x, then roll about the stylus
  // (rad). The axes are those of the device's own base. The hand turns no faster than an arm, and returns to zero by at most half a turn
  // about each axis. The caller sets zero when the hand is no longer led.
  virtual bool turn_hand(const Vec3& /*turn_rad*/) noexcept { return false; }

  // The largest number of points that a scene reports (SceneFacts::kMaxPoints in link/messages.h).
  static constexpr std::size_t kMaxAims = 16;
  // Points of the scene's surface, p_WA (m). The script goes to one of them at random, then to another one; only the first kMaxAims are
  // used. Without points the script searches for the scene.
  virtual bool aim_hand(std::span<const Vec3> /*p_WA*/) noexcept { return false; }
};

}  // namespace hapton
