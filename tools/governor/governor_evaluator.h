#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "safety/safety_governor.h"
#include "tools/governor/hostile_program.h"

namespace hapton {

// Properties that a governor must never violate.
enum class GovernorBreach : std::uint8_t {
  not_finite,
  force,            // above max_force, or above a lowered one for longer than a release takes
  torque,           // as force
  force_slew,       // changed faster than max_slew; a release may be as fast as the device's own
  torque_slew,      // as force_slew
  command_timeout,  // not zero 20 ms after the sample of the last force that counted
  ramp,             // more than the ramp's share of max_force after an opening
  heat,             // more than the thermal budget allows
  energy,           // more than the energy budget allows
  workspace,        // outward force above the soft stop's limit, or not released in time
  gate,             // not released although latched, away, calibrating, pose timed out or not held
  unlatched,        // a fault ended without a reset
  not_latched,      // a fault that latches has not
  count,
};
std::string_view to_string(GovernorBreach breach) noexcept;

// The worst that was seen; each 1 where the limit is.
struct GovernorWorst {
  double force = 0.0;        // of max_force
  double torque = 0.0;       // of max_torque
  double force_slew = 0.0;   // of the device's slew
  double torque_slew = 0.0;  // of the device's slew
  double heat = 0.0;         // load, programs without stalls
  double energy = 0.0;       // given to the hand, as a share of the budget, physical programs
  double release_ms = 0.0;   // from the last turn with an open gate to zero, programs without stalls
};

// Watches one governor from outside, with its own arithmetic: inputs, outputs, and whether they are
// allowed. From the governor it uses only which wrenches it accepted, its fault and its limits. RT: no
// heap.
class GovernorEvaluator {
 public:
  GovernorEvaluator(const HostileProgram& program, const SafetyGovernor& governor) noexcept;

  // After each turn.
  void evaluate(const HostileStep& step, bool was_reset, const Wrench& out) noexcept;

  const std::array<std::uint64_t, static_cast<std::size_t>(GovernorBreach::count)>& breaches() const noexcept { return breaches_; }
  const GovernorWorst& worst() const noexcept { return worst_; }

 private:
  struct Axis {
    std::int64_t shut_ns = -1;  // since when no outward force is allowed; below 0: it is allowed
  };
  // Of what must not come five times on end within 100 ms.
  struct Row {
    bool is_too_long(bool is_bad, std::int64_t now_ns) noexcept;
    int count = 0;
    std::int64_t since_ns = 0;
  };

  void breach_if(GovernorBreach breach, bool is_there) noexcept { breaches_[static_cast<std::size_t>(breach)] += is_there ? 1 : 0; }
  double pass(std::int64_t time_ns) noexcept;
  void see(const HostileStep& step) noexcept;
  void see_motion(const DeviceSample& sample) noexcept;
  void receive(const HostileStep& step) noexcept;
  void check_size(const Wrench& out, double passed_s) noexcept;
  void check_slew(const Wrench& out, double passed_s) noexcept;
  void check_timeout(const Wrench& out) noexcept;
  void check_budgets(const Wrench& out, double passed_s) noexcept;
  void check_workspace(const Wrench& out) noexcept;
  void check_gate(const HostileStep& step, const Wrench& out, double passed_s) noexcept;
  void check_latch(const HostileStep& step, bool was_reset) noexcept;
  double energy_share() const noexcept;

  const SafetyGovernor& governor_;
  std::uint32_t buttons_ = 0;
  bool is_physical_;
  std::array<std::uint64_t, static_cast<std::size_t>(GovernorBreach::count)> breaches_ = {};
  GovernorWorst worst_;

  bool has_begun_ = false;
  std::int64_t now_ns_ = 0;
  std::int64_t out_ns_ = 0;  // of the output before
  Wrench out_;               // on the motors
  std::uint64_t accepted_ = 0;
  std::int64_t accepted_ns_ = 0;  // the sample of the last that counted
  bool is_live_ = false;
  double time_constant_s_ = 0.0;
  double heat_n2_ = 0.0;
  bool has_stalled_ = false;

  bool has_pose_ = false;
  std::int64_t pose_ns_ = 0;
  Vec3 p_m_ = Vec3::Zero();
  Quat q_ = Quat::Identity();
  bool is_current_ = false;
  Vec3 impulse_n_s_ = Vec3::Zero();
  Vec3 turn_impulse_nm_s_ = Vec3::Zero();
  double impulse_s_ = 0.0;
  double spent_j_ = 0.0;
  double given_j_ = 0.0;  // as spent, but never forgotten
  bool has_jumped_ = false;
  std::int64_t anchor_ns_ = -1;  // of the speed over 20 ms; below 0: none
  Vec3 anchor_m_ = Vec3::Zero();
  bool is_too_fast_ = false;

  bool was_open_ = false;
  std::int64_t opened_ns_ = 0;
  std::int64_t open_ns_ = 0;  // the last turn it was
  std::array<Axis, 6> axes_ = {};
  SafetyFault fault_ = SafetyFault::none;
  Row bad_forces_;
  Row bad_torques_;
  Row bad_samples_;
};

}  // namespace hapton
