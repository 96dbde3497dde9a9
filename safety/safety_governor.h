#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "safety/dead_man.h"
#include "safety/energy_budget.h"
#include "safety/motion_watch.h"
#include "safety/ramp.h"
#include "safety/safety_fault.h"
#include "safety/safety_limits.h"
#include "safety/slew_limit.h"
#include "safety/strikes.h"
#include "safety/thermal_budget.h"
#include "safety/wrench_intake.h"

namespace hapton {

// What a governor has done.
struct GovernorCounters {
  std::uint64_t accepted = 0;
  std::uint64_t not_finite = 0;      // forces and torques that are no numbers
  std::uint64_t refused_old = 0;     // repeated, overtaken or older than the silence limit
  std::uint64_t refused_future = 0;  // answers a sample that has not been taken
  std::uint64_t silences = 0;        // times it went quiet after a force had been accepted
  std::uint64_t clamped = 0;         // accepted forces above the limit
  std::uint64_t slewed = 0;          // accepted forces that the slew limit cut
  std::uint64_t bad_samples = 0;     // of the device: no pose
  std::uint64_t stopped = 0;         // accepted forces that the end of the workspace cut
  std::uint64_t braked = 0;          // ... that the speed limit shaped
  std::uint64_t damped = 0;          // ... that the energy budget damped or cut
  std::uint64_t cooled = 0;          // ... that the thermal budget cut
  std::uint64_t releases = 0;        // times the dead man's switch let go
  std::uint64_t latched = 0;         // faults
  std::uint64_t resets = 0;
  std::uint64_t resets_refused = 0;  // their cause was still there
  std::array<std::uint64_t, kSafetyFaults> faults = {};
};

// A governor at one moment, for people and programs.
struct GovernorFigures {
  GovernorCounters counters;
  GovernorState state = GovernorState::silent;
  SafetyFault fault = SafetyFault::none;
  double thermal_load = 0.0;
  double energy_spent_j = 0.0;
  double energy_most_j = 0.0;  // there nothing is left of the force
};

// The last word on every wrench before it reaches the motors of one device, whatever the others send and whatever the device says of
// itself. In this order, each a small type of its own:
//
//   intake      finite, fresh, silence: which wrench counts, and whether any does
//   gate        latched fault, device away or calibrating, no good sample for 20 ms, dead man's switch: no force
//   ramp        when the gate opens, and when forces come again, they come in over kRampNs
//   speed       what pushes a fast device on fades, and damping rises; at max_speed a fault is latched
//   energy      a source that gives the hand more than it took is damped, then cut
//   workspace   what pushes outwards fades to nothing at the end of the workspace
//   ball        the force allowed: max_force, the thermal budget, the energy budget, what can still be let go before the silence limit
//   slew        the output follows with the slew limit, within the ball
//
// So the output is always finite, within max_force and max_torque, within their slews, and within the thermal and the energy budget; zero
// after 20 ms without a force. Nothing switches any of it off: limits can only be tightened, buttons only be asked for.
// Pure: time comes in, nothing is read from a clock. Times are clamped to >= 0; one that goes back counts as no time passed.
// RT: all but making one. Threads: one.
class SafetyGovernor {
 public:
  explicit SafetyGovernor(const DeviceLimits& device);

  void tighten(const DeviceLimits& limits) noexcept { limits_.tighten(limits); }
  void forbid_force() noexcept { limits_.forbid_force(); }
  void require_button(int button) noexcept { dead_man_.require_button(button); }

  // The device as it was just read, at sample.time_ns.
  void observe(const DeviceSample& sample, DeviceStatus status) noexcept;
  // What the device says of its motors: 0 cold .. 1 too hot; below 0: it does not say.
  void observe_temperature(double temperature) noexcept;

  // The wrench to put out now: in answer to wanted, or without news. It must go to the motors as it is.
  const Wrench& step(const std::optional<WantedWrench>& wanted, std::int64_t now_ns) noexcept;

  // Another barrier has taken the force off the motors: it sinks, and ramps in with the next one that is accepted.
  void interrupt() noexcept {
    intake_.let_go();
    is_open_ = false;
  }

  // Set-up: this fault was latched before this program began, and nobody has reset it. Latched again; counted it was then.
  void latch_again(SafetyFault fault) noexcept { fault_ = fault; }

  // A person says that the cause of the latched fault is mended. False: it is still there, and so is the fault. The force ramps in.
  bool reset_faults() noexcept;
  // A dead man's switch is asked for, and held: a person is at the device. A device that is away repeats its last sample, which says
  // nothing of now.
  bool is_switch_held() const noexcept {
    return dead_man_.required_buttons() != 0 && is_held_ && status_ == DeviceStatus::ready && motion_.is_current(now_ns_);
  }

  const Wrench& output() const noexcept { return out_; }
  SafetyFault fault() const noexcept { return fault_; }
  GovernorState state() const noexcept;
  // No force is there or can be, until another one is accepted.
  bool is_silent() const noexcept { return !intake_.is_live(); }
  const DeviceLimits& limits() const noexcept { return limits_.now(); }
  const DeviceLimits& device_limits() const noexcept { return limits_.device(); }
  const GovernorCounters& counters() const noexcept { return counters_; }
  double thermal_load() const noexcept { return thermal_.load(limits_.now()); }
  double energy_spent_j() const noexcept { return energy_.spent_j(); }
  bool is_energy_gone() const noexcept { return energy_.share(limits().max_force_n) == 0.0; }
  GovernorFigures figures() const noexcept {
    return {counters_, state(), fault_, thermal_load(), energy_spent_j(), EnergyBudget::most_j(limits().max_force_n)};
  }
  double speed_m_per_s() const noexcept { return motion_.speed_m_per_s(); }
  double most_damping_n_s_per_m() const noexcept;

 private:
  double advance(std::int64_t now_ns) noexcept;
  void latch(SafetyFault fault) noexcept;
  bool is_cause_there() const noexcept;
  void take(const WantedWrench& wanted) noexcept;
  void look(const DeviceSample& sample) noexcept;
  GovernorState gate() const noexcept;
  double allowed_share() const noexcept;
  void follow(double ramp, double share, double left_s, double passed_s) noexcept;
  Vec3 shaped_n(double ramp) noexcept;
  void count_accepted() noexcept;

  SafetyLimits limits_;
  DeadMan dead_man_;
  WrenchIntake intake_;
  Ramp ramp_;
  MotionWatch motion_;
  ThermalBudget thermal_;
  EnergyBudget energy_;
  SlewLimit force_;
  SlewLimit torque_;
  Strikes bad_forces_;
  Strikes bad_torques_;
  Strikes bad_samples_;
  Wrench out_;
  GovernorCounters counters_;
  SafetyFault fault_ = SafetyFault::none;
  DeviceStatus status_ = DeviceStatus::ready;
  double temperature_ = -1.0;
  bool is_held_ = true;
  bool is_open_ = false;
  bool is_accepted_ = false;  // in this step
  bool was_stopped_ = false;  // ... and what was done to it
  bool was_braked_ = false;
  bool was_damped_ = false;
  bool has_begun_ = false;
  std::int64_t now_ns_ = 0;
  double unheld_s_ = 0.0;  // passed since the last step: the slew of the next
};

}  // namespace hapton
