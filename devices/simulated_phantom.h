#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "devices/device.h"
#include "devices/hand_script.h"
#include "devices/stylus_dynamics.h"
#include "devices/stylus_turn.h"

namespace hapton {

// A PHANToM Model A (model_a.h) with a hand on it: 6 DOF in and 3 DOF out, force passed on up to 30 Hz. The three axes are alike and
// independent (stylus_dynamics.h); gimbals carry no motor, so the stylus tilts as the hand wants. With motors on the gimbals, as the later
// Premium 6DOF had, it gives torque as well, and the stylus turns as StylusTurn says. The hand follows a seeded script
// (hand_script.h), takes a path or is led.
// Time: the first read or write sets the device's zero; the trajectory depends on the forces and the times they were written,
// not on how often the device is read. A pause of more than kLongestPauseNs is cut to it (a stopped process is not a long flight).
// RT: all but making one: bounded, about 2 us for each simulated millisecond.
class SimulatedPhantom final : public Device {
 public:
  // Far longer than a cycle; it bounds the work of one read to 0.2 ms.
  static constexpr std::int64_t kLongestPauseNs = 100'000'000;

  struct Options {
    std::uint64_t seed = 1;
    StylusModel stylus = {};
    std::vector<TrajectoryRow> path = {};  // the path that the hand takes instead of its script (hand_script.h); empty: none
    bool repeat_path = false;
    bool has_torque = false;  // motors on the gimbals
  };

  explicit SimulatedPhantom(const Options& options);

  std::string_view name() const noexcept override { return has_torque_ ? "simulated-6dof" : "simulated"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override;
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override;
  bool cut() noexcept override {
    is_cut_.store(true, std::memory_order_release);
    if (heartbeat_page_ != nullptr) heartbeat_page_->is_cut_within.store(1, std::memory_order_release);
    return true;
  }
  void restore() noexcept override {
    is_cut_.store(false, std::memory_order_release);
    if (heartbeat_page_ != nullptr) heartbeat_page_->is_cut_within.store(0, std::memory_order_release);
  }
  void use_heartbeat_page(HeartbeatPage& page) noexcept override {
    page.set_means(CutMeans::simulated);
    heartbeat_page_ = &page;
  }
  DeviceStatus status() const noexcept override { return DeviceStatus::ready; }
  bool set_hand_target(const std::optional<Vec3>& p_WH) noexcept override;
  bool press_hand_buttons(std::uint32_t buttons) noexcept override;
  bool turn_hand(const Vec3& turn_rad) noexcept override;
  bool aim_hand(std::span<const Vec3> p_WA) noexcept override;

  // The position without the steps of the encoders, and the phase of the script, for tests and plots: a real device does not tell these.
  Vec3 exact_position_m() const noexcept;
  HandScript::Phase phase() const noexcept { return script_.phase(); }

 private:
  void advance_to(std::int64_t now_ns) noexcept;
  void begin_hand_step() noexcept;
  Quat target_orientation() const noexcept;

  DeviceLimits limits_;
  StylusDynamics dynamics_;
  HandScript script_;
  std::array<AxisState, 3> axes_;
  Vec3 written_n_ = Vec3::Zero();
  Vec3 force_n_ = Vec3::Zero();  // on the motors: written, unless they are cut
  std::atomic<bool> is_cut_{false};
  HeartbeatPage* heartbeat_page_ = nullptr;  // shows the motors to the watchdog process, which can cut them there
  Vec3 hand_m_;                              // the hand's intended position at device_ns_
  Vec3 hand_m_per_s_ = Vec3::Zero();
  Vec3 gimbal_rad_ = Vec3::Zero();
  std::uint32_t buttons_ = 0;          // buttons that the path holds down
  std::uint32_t pressed_buttons_ = 0;  // buttons held down by press_hand_buttons
  Vec3 turn_goal_rad_ = Vec3::Zero();  // the turn set by turn_hand
  Vec3 turn_rad_ = Vec3::Zero();       // the present turn, on the way to that goal
  std::optional<Quat> q_WH_;           // on a path that has orientations, in place of the gimbals
  bool has_torque_;
  StylusTurn turn_;  // used only with has_torque_
  Vec3 written_nm_ = Vec3::Zero();
  Vec3 torque_nm_ = Vec3::Zero();  // on the motors, as force_n_
  std::int64_t zero_ns_ = 0;       // host time of device time 0
  std::int64_t device_ns_ = -1;    // device time reached; below 0: not begun
};

}  // namespace hapton
