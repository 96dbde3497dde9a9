#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "safety/safety_governor.h"
#include "tools/governor/hostile_program.h"

namespace hapton {

// Properties that a governor must never violate. Its gate is open while nothing forbids a force: see `gate`.
enum class GovernorBreach : std::uint8_t {
  not_finite,
  force,            // above max_force, or above a lowered one for longer than a release takes
  torque,           // the same for torque
  force_slew,       // the force changed faster than max_slew, or was released faster than the max_slew of the device
  torque_slew,      // the same for torque
  command_timeout,  // force or torque is not zero 20 ms after the sample of the last accepted command
  ramp,             // the force is above the share of max_force that the ramp up allows after the gate has opened
  heat,             // the force is above what the thermal budget allows
  energy,           // the force is above what the energy budget allows
  workspace,        // outward force above the soft stop's limit, or not released in time
  gate,             // no release although: latched fault, away, calibrating, pose or command timeout, button not held
  unlatched,        // a fault ended without a reset
  not_latched,      // a fault that must latch did not
  count,
};
std::string_view to_string(GovernorBreach breach) noexcept;

// The largest values that were seen. Each is a share of its limit, so that 1 is the limit, except release_ms.
struct GovernorWorst {
  double force = 0.0;        // share of the device's max_force
  double torque = 0.0;       // share of the device's max_torque
  double force_slew = 0.0;   // share of the device's max_slew
  double torque_slew = 0.0;  // share of the device's max_torque_slew
  double heat = 0.0;         // load of the thermal budget, in physical programs before their first stall (20 ms)
  double energy = 0.0;       // energy given to the hand, as a share of budget and one release, in physical programs
  double release_ms = 0.0;   // time from the last turn with an open gate to zero force, before the first stall
};

// Watches the inputs and outputs of one governor, and computes independently of it which outputs are allowed. From the governor it takes
// only which commands it accepted, its fault, its limits and its speed estimate. A turn is one cycle: a device sample and a force command.
// RT: no heap. Threads: one.
class GovernorEvaluator {
 public:
  GovernorEvaluator(const HostileProgram& program, const SafetyGovernor& governor) noexcept;

  // Checks one turn. Pre: called after each turn. was_reset: the governor accepted step.resets_faults. out: the governor's output.
  void evaluate(const HostileStep& step, bool was_reset, const Wrench& out) noexcept;

  const std::array<std::uint64_t, static_cast<std::size_t>(GovernorBreach::count)>& breaches() const noexcept { return breaches_; }
  const GovernorWorst& worst() const noexcept { return worst_; }

 private:
  // One of the six faces of the workspace.
  struct Side {
    std::int64_t shut_ns = -1;  // since when no outward force is allowed; below 0: outward force is allowed
  };
  // Counts errors of one kind: five in a row within 100 ms must latch a fault.
  struct ErrorRun {
    bool is_too_long(bool is_bad, std::int64_t now_ns) noexcept;
    int count = 0;
    std::int64_t since_ns = 0;
  };

  void breach_if(GovernorBreach breach, bool is_breach) noexcept { breaches_[static_cast<std::size_t>(breach)] += is_breach ? 1 : 0; }
  double advance_to(std::int64_t time_ns) noexcept;
  void observe(const HostileStep& step) noexcept;
  void observe_motion(const DeviceSample& sample) noexcept;
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
  std::int64_t out_ns_ = 0;  // time of the last output
  Wrench out_;               // the last output, which is on the motors
  std::uint64_t accepted_ = 0;
  std::int64_t accepted_ns_ = 0;  // time of the sample of the last accepted command
  bool is_live_ = false;          // an accepted command takes effect
  double time_constant_s_ = 0.0;  // of the motors' heat; 0: the device states no continuous force
  double heat_n2_ = 0.0;          // running mean of the squared force
  bool has_stalled_ = false;      // more than 20 ms have passed between two turns

  bool has_pose_ = false;
  std::int64_t pose_ns_ = 0;
  Vec3 p_m_ = Vec3::Zero();
  Quat q_ = Quat::Identity();
  bool is_current_ = false;                // the pose is not older than the pose timeout
  Vec3 impulse_n_s_ = Vec3::Zero();        // of the force since the last pose
  Vec3 turn_impulse_nm_s_ = Vec3::Zero();  // of the torque since then
  double impulse_s_ = 0.0;                 // the time since then
  double spent_j_ = 0.0;                   // count of the energy budget: energy given to the hand
  double given_j_ = 0.0;                   // like spent_j_, but not limited from above
  bool has_jumped_ = false;
  std::int64_t anchor_ns_ = -1;  // start of the 20 ms over which the speed is measured; below 0: none
  Vec3 anchor_m_ = Vec3::Zero();
  bool is_too_fast_ = false;

  bool was_open_ = false;
  std::int64_t opened_ns_ = 0;
  std::int64_t open_ns_ = 0;  // time of the last turn with an open gate
  std::array<Side, 6> sides_ = {};
  SafetyFault fault_ = SafetyFault::none;
  ErrorRun bad_forces_;
  ErrorRun bad_torques_;
  ErrorRun bad_samples_;
};

}  // namespace hapton
