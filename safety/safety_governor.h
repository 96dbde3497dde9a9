#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "safety/command_filter.h"
#include "safety/dead_mans_switch.h"
#include "safety/energy_budget.h"
#include "safety/fault_debouncer.h"
#include "safety/motion_monitor.h"
#include "safety/passivity_controller.h"
#include "safety/ramp_up.h"
#include "safety/safety_fault.h"
#include "safety/safety_limits.h"
#include "safety/slew_limit.h"
#include "safety/thermal_budget.h"

namespace hapton {

// What a governor has done, in numbers.
struct GovernorCounters {
  std::uint64_t accepted = 0;
  std::uint64_t not_finite = 0;         // forces and torques
  std::uint64_t rejected_old = 0;       // repeated, reordered or older than the command timeout
  std::uint64_t rejected_future = 0;    // replies to a sample that has not been taken
  std::uint64_t command_timeouts = 0;   // command timeouts after an accepted force
  std::uint64_t clamped = 0;            // accepted forces above the limit
  std::uint64_t rate_limited = 0;       // accepted forces limited in rate
  std::uint64_t bad_samples = 0;        // samples of the device with an invalid pose
  std::uint64_t workspace_limited = 0;  // accepted forces limited by the workspace
  std::uint64_t speed_limited = 0;      // ... by the speed limit
  std::uint64_t damped = 0;             // ... by the energy budget
  std::uint64_t kept_passive = 0;       // ... by the passivity controller
  std::uint64_t thermal_limited = 0;    // ... by the thermal budget
  std::uint64_t releases = 0;           // times the dead man's switch was released
  std::uint64_t latched = 0;            // faults that were latched
  std::uint64_t resets = 0;
  std::uint64_t resets_rejected = 0;  // resets of a fault whose cause persisted
  std::array<std::uint64_t, kSafetyFaults> faults = {};
};

// The state of a governor at one moment, for people and programs.
struct GovernorStats {
  GovernorCounters counters;
  GovernorState state = GovernorState::no_command;
  SafetyFault fault = SafetyFault::none;
  double thermal_load = 0.0;
  double energy_spent_j = 0.0;
  double energy_most_j = 0.0;      // at this energy the force limit is zero
  double passivity_given_j = 0.0;  // see PassivityController; 0 where it is off

  // Used share of the energy budget; below 0: the device has taken more than it gave.
  double energy_share() const noexcept { return energy_most_j > 0.0 ? energy_spent_j / energy_most_j : 0.0; }
};

// Limits every wrench before it reaches the motors of one device, whatever the other nodes send and whatever the device reports. Its
// stages, in this order, most of them a type of their own:
//
//   filter      finite, fresh, not timed out: which command is valid (CommandFilter)
//   gate        latched fault, device away or calibrating, no valid sample for 20 ms, dead man's switch: no force
//   ramp        when the gate opens, and after a command timeout, the force ramps up over kRampNs
//   speed       force along the motion of a fast device fades, and damping rises; at max_speed a fault is latched
//   passivity   if it is enabled: no more energy than the hand put in
//   energy      a source that gives the hand more energy than it took is damped, then limited
//   workspace   outward force fades to zero at the end of the workspace
//   magnitude   the force limit: max_force, the thermal budget, the energy budget, and the force that can still be released by the
//               command timeout
//   slew        the output follows at the rate limit, within the magnitude limit
//
// So the output is always finite, within max_force and max_torque, within their slews, and within the thermal and the energy budget; zero
// after 20 ms without a force. Limits that are tightened hold as soon as the device's own slew permits: releases use it. Nothing switches a
// stage off: limits can only be tightened, buttons only be required. Time is a parameter, no clock is read: times are clamped to >= 0; a
// decreasing time counts as no time passed. RT: all but construction. Threads: one.
class SafetyGovernor {
 public:
  explicit SafetyGovernor(const DeviceLimits& device);

  void tighten(const DeviceLimits& limits) noexcept { limits_.tighten(limits); }
  void forbid_force() noexcept { limits_.forbid_force(); }
  void forbid_torque() noexcept { limits_.forbid_torque(); }
  // Enables the passivity stage from now on. Without it only a source that gives more than the energy budget is limited.
  void keep_passive(const PassivityController::Mechanics& device) noexcept { passivity_.emplace(device); }
  void require_button(int button) noexcept { dead_mans_switch_.require_button(button); }

  // The device as it was just read, at sample.time_ns.
  void observe(const DeviceSample& sample, DeviceStatus status) noexcept;
  // The temperature of the motors as the device reports it: 0 cold .. 1 too hot; below 0: not reported.
  void observe_temperature(double temperature) noexcept;

  // The wrench to write now: in reply to `command`, or without a new command. Write it unchanged.
  const Wrench& step(const std::optional<WrenchCommand>& command, std::int64_t now_ns) noexcept;

  // Another barrier has released the force: it ramps up again with the next accepted command.
  void interrupt() noexcept {
    filter_.release();
    is_gate_open_ = false;
  }

  // Set-up: this fault was latched before this program started and has not been reset. It is latched again, and not counted again. After
  // `thermal` the motors count as hot.
  void restore_latched_fault(SafetyFault fault) noexcept {
    fault_ = fault;
    if (fault == SafetyFault::thermal) thermal_.assume_hot(limits_.device());
  }

  // A person says that the cause of the latched fault is gone. False: it is not, and the fault stays latched. True: the force may ramp up.
  bool reset_faults() noexcept;
  // A dead man's switch is required, and held: a person is at the device. A disconnected device repeats its last sample, which proves
  // nothing.
  bool is_switch_held() const noexcept {
    return dead_mans_switch_.required_buttons() != 0 && is_switch_held_ && status_ == DeviceStatus::ready && motion_.is_current(now_ns_);
  }

  const Wrench& output() const noexcept { return output_; }
  SafetyFault fault() const noexcept { return fault_; }
  GovernorState state() const noexcept;
  // No valid command within the command timeout, or none yet: the force is zero or ramping down.
  bool has_timed_out() const noexcept { return !filter_.is_live(); }
  const DeviceLimits& limits() const noexcept { return limits_.current(); }
  const DeviceLimits& device_limits() const noexcept { return limits_.device(); }
  const GovernorCounters& counters() const noexcept { return counters_; }
  // Load of the motors by limits(); where these allow no force, by the device's own continuous force.
  double thermal_load() const noexcept { return thermal_.load(limits().max_force_n > 0.0 ? limits() : device_limits()); }
  double energy_spent_j() const noexcept { return energy_.spent_j(); }
  double passivity_given_j() const noexcept { return passivity_ ? passivity_->given_j() : 0.0; }
  bool is_energy_gone() const noexcept { return energy_.share(limits().max_force_n) == 0.0; }
  GovernorStats stats() const noexcept {
    return {counters_, state(), fault_, thermal_load(), energy_spent_j(), EnergyBudget::most_j(limits().max_force_n), passivity_given_j()};
  }
  double speed_m_per_s() const noexcept { return motion_.speed_m_per_s(); }
  // The largest damping that the stages use, from the device's own limits.
  double most_damping_n_s_per_m() const noexcept;

 private:
  double advance(std::int64_t now_ns) noexcept;
  void latch(SafetyFault fault) noexcept;
  bool has_cause() const noexcept;
  void take(const WrenchCommand& command) noexcept;
  void check_motion(const DeviceSample& sample) noexcept;
  GovernorState gate() const noexcept;
  double allowed_share() const noexcept;
  void follow(double ramp, double share, double left_s, double passed_s) noexcept;
  Vec3 shaped_n(double ramp) noexcept;
  void count_accepted() noexcept;

  SafetyLimits limits_;
  DeadMansSwitch dead_mans_switch_;
  CommandFilter filter_;
  RampUp ramp_up_;
  MotionMonitor motion_;
  ThermalBudget thermal_;
  EnergyBudget energy_;
  std::optional<PassivityController> passivity_;
  SlewLimit force_slew_;
  SlewLimit torque_slew_;
  FaultDebouncer bad_forces_;
  FaultDebouncer bad_torques_;
  FaultDebouncer bad_samples_;
  Wrench output_;
  GovernorCounters counters_;
  SafetyFault fault_ = SafetyFault::none;
  DeviceStatus status_ = DeviceStatus::ready;
  double temperature_ = -1.0;
  bool is_switch_held_ = true;
  bool is_gate_open_ = false;
  bool is_accepted_ = false;            // a command was accepted in this step
  bool was_workspace_limited_ = false;  // ... and this stage limited its force
  bool was_speed_limited_ = false;
  bool was_damped_ = false;
  bool was_kept_passive_ = false;
  bool has_begun_ = false;
  std::int64_t now_ns_ = 0;
  double since_step_s_ = 0.0;  // time passed since the last step: it bounds the change in the next
};

}  // namespace hapton
