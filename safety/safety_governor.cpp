#include "safety/safety_governor.h"

#include <algorithm>
#include <utility>

#include "safety/speed_limit.h"
#include "safety/vector_limit.h"
#include "safety/workspace_stop.h"

namespace hapton {
namespace {

// Small enough that a difference of two times cannot overflow.
constexpr std::int64_t kLatestNs = std::int64_t{1} << 62;

// The largest damping is this times the device's largest stiffness: 2 N s/m for 1,000 N/m. A choice: far below mass / period (70 N s/m for
// 70 g at 1 kHz), with which the force of one period would stop the mass. It is above the device's own damping, up to which passivity is
// certain (Colgate and Brown, "Factors affecting the Z-width of a haptic display", 1994). If that stiffness is not known, the damping is
// such that its force reaches max_force at 1 m/s.
constexpr double kDampingS = 0.002;

// A motor temperature (DeviceCondition::motor_temperature) of kTooHot or more is a fault. It can be reset when the temperature and the load
// of the thermal budget are at most kCoolAgain: at kTooHot itself it would soon latch again.
constexpr double kTooHot = 1.0;
constexpr double kCoolAgain = 0.9;

}  // namespace

SafetyGovernor::SafetyGovernor(const DeviceLimits& device) : limits_(device), thermal_(limits_.device()) {}

double SafetyGovernor::most_damping_n_s_per_m() const noexcept {
  const double stiffness = limits_.device().max_stiffness_n_per_m;
  return stiffness > 0.0 ? kDampingS * stiffness : limits_.device().max_force_n;
}

// Returns the time since the last call. The motors had the wrench output_ during that time.
double SafetyGovernor::advance(std::int64_t now_ns) noexcept {
  now_ns = std::clamp(now_ns, std::int64_t{0}, kLatestNs);
  if (!std::exchange(has_begun_, true)) now_ns_ = now_ns;
  const double passed_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(0, now_ns - now_ns_));
  now_ns_ = std::max(now_ns_, now_ns);
  thermal_.note_applied(output_.force_n, passed_s);
  energy_.note_applied(output_, passed_s);
  if (passivity_) passivity_->note_applied(output_.force_n, passed_s);
  if (thermal_.load(limits_.device()) > ThermalBudget::kFaultLoad) latch(SafetyFault::thermal);
  return passed_s;
}

void SafetyGovernor::latch(SafetyFault fault) noexcept {
  if (fault_ != SafetyFault::none) return;
  fault_ = fault;
  ++counters_.latched;
  ++counters_.faults[static_cast<std::size_t>(fault)];
}

bool SafetyGovernor::has_cause() const noexcept {
  return status_ == DeviceStatus::fault || thermal_.load(limits_.device()) > kCoolAgain || temperature_ > kCoolAgain ||
         !motion_.is_current(now_ns_) || SpeedLimit::is_soft(limits_.current(), motion_.speed_m_per_s());
}

bool SafetyGovernor::reset_faults() noexcept {
  if (fault_ == SafetyFault::none) return true;
  if (has_cause()) {
    ++counters_.resets_rejected;
    return false;
  }
  fault_ = SafetyFault::none;
  bad_forces_.clear();
  bad_torques_.clear();
  bad_samples_.clear();
  ++counters_.resets;
  return true;
}

void SafetyGovernor::observe(const DeviceSample& sample, DeviceStatus status) noexcept {
  since_step_s_ += advance(sample.time_ns);
  status_ = status;
  if (status == DeviceStatus::fault) latch(SafetyFault::device);
  const bool was_held = std::exchange(is_switch_held_, dead_mans_switch_.is_held(sample));
  if (was_held && !is_switch_held_) ++counters_.releases;
  if (status == DeviceStatus::away || status == DeviceStatus::calibrating) {
    motion_.forget();
  } else {
    check_motion(sample);
  }
  // A gate that was closed, however briefly, is followed by a ramp up.
  is_gate_open_ = is_gate_open_ && gate() == GovernorState::live;
}

void SafetyGovernor::check_motion(const DeviceSample& sample) noexcept {
  const DeviceLimits& limits = limits_.current();
  switch (motion_.update(sample, now_ns_, limits.max_speed_m_per_s, limits.max_torque_nm > 0.0)) {
    case MotionMonitor::Verdict::fine:
      break;
    case MotionMonitor::Verdict::invalid_pose:
      ++counters_.bad_samples;
      if (bad_samples_.note(now_ns_)) latch(SafetyFault::position);
      return;
    case MotionMonitor::Verdict::jump:
      latch(SafetyFault::jump);
      break;
  }
  if (SpeedLimit::is_exceeded(limits, motion_.speed_m_per_s())) latch(SafetyFault::speed);
  energy_.observe(limits.max_force_n, output_, motion_.moved_m(), motion_.turned_rad());
  if (passivity_) passivity_->observe(limits.max_force_n, motion_.moved_m());
}

void SafetyGovernor::observe_temperature(double temperature) noexcept {
  temperature_ = temperature;
  if (temperature >= kTooHot) latch(SafetyFault::thermal);
}

void SafetyGovernor::take(const WrenchCommand& command) noexcept {
  switch (filter_.take(command, now_ns_)) {
    case CommandFilter::Verdict::accepted:
      ++counters_.accepted;
      is_accepted_ = true;
      return;
    case CommandFilter::Verdict::force_not_finite:
      ++counters_.not_finite;
      if (bad_forces_.note(now_ns_)) latch(SafetyFault::not_finite);
      return;
    case CommandFilter::Verdict::torque_not_finite:
      ++counters_.not_finite;
      if (bad_torques_.note(now_ns_)) latch(SafetyFault::torque);
      return;
    case CommandFilter::Verdict::future:
      ++counters_.rejected_future;
      return;
    case CommandFilter::Verdict::old:
      ++counters_.rejected_old;
      return;
  }
}

GovernorState SafetyGovernor::gate() const noexcept {
  if (fault_ != SafetyFault::none) return GovernorState::latched;
  if (status_ == DeviceStatus::away) return GovernorState::away;
  if (status_ == DeviceStatus::calibrating) return GovernorState::calibrating;
  if (!motion_.is_current(now_ns_)) return GovernorState::pose_timeout;
  if (!is_switch_held_) return GovernorState::switch_released;
  return filter_.is_live() ? GovernorState::live : GovernorState::no_command;
}

GovernorState SafetyGovernor::state() const noexcept {
  const GovernorState state = gate();
  return state == GovernorState::live && ramp_up_.share(now_ns_) < 1.0 ? GovernorState::ramping : state;
}

// The share of max_force and of max_torque that the thermal budget and the energy budget allow.
double SafetyGovernor::allowed_share() const noexcept {
  const DeviceLimits& limits = limits_.current();
  if (limits.max_force_n == 0.0) return 0.0;
  return std::min(thermal_.allowed_n(limits) / limits.max_force_n, energy_.share(limits.max_force_n));
}

// The requested force, limited and damped for the position and the motion of the device.
Vec3 SafetyGovernor::shaped_n(double ramp) noexcept {
  const DeviceLimits& limits = limits_.current();
  const double most_damping = most_damping_n_s_per_m();
  const Vec3 wanted_n = ramp * shortened(filter_.wrench().force_n, limits.max_force_n);
  Vec3 force_n = SpeedLimit::limit_force(limits, most_damping, wanted_n, motion_);
  was_speed_limited_ = SpeedLimit::is_soft(limits, motion_.speed_m_per_s());
  if (passivity_) {
    force_n = passivity_->shape(force_n, most_damping);
    was_kept_passive_ = passivity_->has_limited();
  }
  const double damping = energy_.damping_n_s_per_m(limits.max_force_n, motion_.speed_m_per_s(), most_damping);
  if (damping > 0.0) force_n -= damping * motion_.velocity_m_per_s();
  was_damped_ = damping > 0.0;
  force_n = shortened(force_n, limits.max_force_n);
  const Vec3 inside_n = WorkspaceStop::shape(limits, force_n, motion_.p_WD());
  was_workspace_limited_ = inside_n != force_n;
  return inside_n;
}

const Wrench& SafetyGovernor::step(const std::optional<WrenchCommand>& command, std::int64_t now_ns) noexcept {
  const double passed_s = std::exchange(since_step_s_, 0.0) + advance(now_ns);
  if (filter_.times_out(now_ns_)) {
    ++counters_.command_timeouts;
    is_gate_open_ = false;
  }
  is_accepted_ = was_workspace_limited_ = was_speed_limited_ = was_damped_ = was_kept_passive_ = false;
  if (command) take(*command);
  const bool was_open = std::exchange(is_gate_open_, gate() == GovernorState::live);
  if (is_gate_open_ && !was_open) ramp_up_.begin(now_ns_);
  if (is_gate_open_) {
    follow(ramp_up_.share(now_ns_), allowed_share(), filter_.left_s(now_ns_), passed_s);
  } else {
    follow(0.0, 0.0, 0.0, passed_s);
  }
  if (is_accepted_ && is_gate_open_) count_accepted();
  return output_;
}

// ramp: share of the requested wrench; share: share of the limits that may be used; left_s: time until the output has to be zero.
void SafetyGovernor::follow(double ramp, double share, double left_s, double passed_s) noexcept {
  const DeviceLimits& limits = limits_.current();
  const double limit_n = std::min(share * limits.max_force_n, limits_.release_n_per_s() * left_s);
  output_.force_n = force_slew_.follow(ramp > 0.0 ? shaped_n(ramp) : Vec3(Vec3::Zero()), limit_n,
                                       {limits.max_slew_n_per_s * passed_s, limits_.release_n_per_s() * passed_s});
  if (limits_.device().max_torque_nm == 0.0) return;
  const double limit_nm = std::min(share * limits.max_torque_nm, limits_.release_nm_per_s() * left_s);
  output_.torque_nm = torque_slew_.follow(ramp * shortened(filter_.wrench().torque_nm, limits.max_torque_nm), limit_nm,
                                          {limits.max_torque_slew_nm_per_s * passed_s, limits_.release_nm_per_s() * passed_s});
}

void SafetyGovernor::count_accepted() noexcept {
  const DeviceLimits& limits = limits_.current();
  const double wanted_n = length_of(filter_.wrench().force_n);
  counters_.clamped += wanted_n > limits.max_force_n ? 1 : 0;
  counters_.rate_limited += force_slew_.was_limited() ? 1 : 0;
  counters_.workspace_limited += was_workspace_limited_ ? 1 : 0;
  counters_.speed_limited += was_speed_limited_ ? 1 : 0;
  counters_.kept_passive += was_kept_passive_ ? 1 : 0;
  const double energy_n = limits.max_force_n * energy_.share(limits.max_force_n);
  counters_.damped += was_damped_ || energy_n < std::min(wanted_n, limits.max_force_n) ? 1 : 0;
  counters_.thermal_limited += thermal_.allowed_n(limits) < std::min(wanted_n, limits.max_force_n) ? 1 : 0;
}

}  // namespace hapton
