#include "tools/governor/governor_evaluator.h"

#include <algorithm>
#include <cmath>

#include "core/base/button_bit.h"

namespace hapton {
namespace {

// The bounds that docs/safety.md promises. They are written here again, because the check must not use the governor's own values.
constexpr std::int64_t kAgeLimitNs = 20'000'000;     // of a command (command timeout) and of a pose (pose timeout)
constexpr std::int64_t kRampUpNs = 100'000'000;      // from the opening of the gate to the full force
constexpr std::int64_t kGapNs = 100'000'000;         // between two poses; after a longer gap no motion is a jump
constexpr std::int64_t kSpeedWindowNs = 20'000'000;  // over which the speed is measured
constexpr double kJumpM = 0.005;                     // farther than max_speed allows, and the motion is a jump
constexpr double kWorkspaceMarginM = 0.010;          // before each face of the workspace, in which the outward force falls to zero
// The energy budget divided by max_force, in m: from the first value on the force is reduced, from the second on it is zero, and above the
// third the count does not rise. The last value, in m/s, is deducted from the count all the time.
constexpr double kFreeEnergyM = 0.010, kMaxEnergyM = 0.030, kSaturationEnergyM = 0.036, kForgivenMPerS = 0.002;

// The limit plus an allowance for rounding, relative and absolute.
double with_tolerance(double limit) { return limit * (1.0 + 1e-9) + 1e-12; }

double size_of(const Vec3& v) { return v.stableNorm(); }

bool is_finite(const Wrench& wrench) { return wrench.force_n.allFinite() && wrench.torque_nm.allFinite(); }

bool is_pose(const DeviceSample& sample) {
  return sample.p_WD.allFinite() && sample.p_WD.cwiseAbs().maxCoeff() <= 1e6 && sample.q_WT.coeffs().allFinite() &&
         std::abs(sample.q_WT.squaredNorm() - 1.0) <= 2e-3;
}

}  // namespace

std::string_view to_string(GovernorBreach breach) noexcept {
  constexpr std::array<std::string_view, static_cast<std::size_t>(GovernorBreach::count)> kNames = {
      "not finite", "force",  "torque",    "force slew", "torque slew", "command timeout", "ramp",
      "heat",       "energy", "workspace", "gate",       "unlatched",   "not latched",
  };
  return kNames[static_cast<std::size_t>(breach)];
}

GovernorEvaluator::GovernorEvaluator(const HostileProgram& program, const SafetyGovernor& governor) noexcept
    : governor_(governor), is_physical_(program.is_physical()) {
  buttons_ = button_bit(program.button());
  const DeviceLimits& device = governor.device_limits();
  const double ratio = device.continuous_force_n / device.max_force_n;
  if (device.peak_s > 0.0 && ratio < 1.0) time_constant_s_ = -device.peak_s / std::log(1.0 - ratio * ratio);
}

// Advances the time as the governor does: clamped, never back. The wrench out_ heated the motors and moved the device meanwhile. Returns
// the time that has passed, s.
double GovernorEvaluator::advance_to(std::int64_t time_ns) noexcept {
  const std::int64_t to_ns = std::clamp(time_ns, std::int64_t{0}, std::int64_t{1} << 62);
  if (!has_begun_) now_ns_ = out_ns_ = to_ns;
  has_begun_ = true;
  const double passed_s = to_ns > now_ns_ ? 1e-9 * static_cast<double>(to_ns - now_ns_) : 0.0;
  now_ns_ = std::max(now_ns_, to_ns);
  if (passed_s > 0.02) has_stalled_ = true;
  if (time_constant_s_ > 0.0) {
    const double heat_goal_n2 = out_.force_n.squaredNorm();
    heat_n2_ = heat_goal_n2 + (heat_n2_ - heat_goal_n2) * std::exp(-std::min(passed_s, 1.0) / time_constant_s_);
  }
  impulse_n_s_ += out_.force_n * passed_s;
  turn_impulse_nm_s_ += out_.torque_nm * passed_s;
  impulse_s_ += passed_s;
  return passed_s;
}

void GovernorEvaluator::observe(const HostileStep& step) noexcept {
  advance_to(step.sample.time_ns);
  has_jumped_ = false;
  if (step.status == DeviceStatus::away || step.status == DeviceStatus::calibrating) {
    has_pose_ = false;
    anchor_ns_ = -1;
  } else if (is_pose(step.sample)) {
    observe_motion(step.sample);
  }
  is_current_ = has_pose_ && now_ns_ - pose_ns_ < kAgeLimitNs;
}

void GovernorEvaluator::observe_motion(const DeviceSample& sample) noexcept {
  const double most_n = governor_.limits().max_force_n;
  const double speed = governor_.limits().max_speed_m_per_s;
  const double passed_s = 1e-9 * static_cast<double>(now_ns_ - pose_ns_);
  const Vec3 moved = sample.p_WD - p_m_;
  const bool is_after_gap = has_pose_ && now_ns_ - pose_ns_ > kGapNs;
  const Quat turn = sample.q_WT * q_.conjugate();
  const Vec3 turned = governor_.limits().max_torque_nm > 0.0 ? Vec3((turn.w() < 0.0 ? -2.0 : 2.0) * turn.vec()) : Vec3(Vec3::Zero());
  has_jumped_ = has_pose_ && !is_after_gap &&
                (moved.norm() > with_tolerance(speed * passed_s + kJumpM) || turned.norm() > with_tolerance(50.0 * passed_s + 0.2));
  double given_j = 0.0;
  if (has_pose_ && !has_jumped_) {
    given_j = impulse_s_ > 0.0 ? (impulse_n_s_.dot(moved) + turn_impulse_nm_s_.dot(turned)) / impulse_s_
                               : out_.force_n.dot(moved) + out_.torque_nm.dot(turned);
  }
  const double change_j = given_j - kForgivenMPerS * most_n * impulse_s_;
  spent_j_ = std::clamp(spent_j_ + change_j, -kFreeEnergyM * most_n, kSaturationEnergyM * most_n);
  given_j_ = std::max(given_j_ + change_j, -kFreeEnergyM * most_n);
  impulse_n_s_ = turn_impulse_nm_s_ = Vec3::Zero();
  impulse_s_ = 0.0;
  if (anchor_ns_ < 0 || is_after_gap || has_jumped_) {
    anchor_ns_ = now_ns_;
    anchor_m_ = sample.p_WD;
  }
  is_too_fast_ = false;
  if (now_ns_ - anchor_ns_ >= kSpeedWindowNs) {
    is_too_fast_ = (sample.p_WD - anchor_m_).norm() > 2.0 * speed * 1e-9 * static_cast<double>(now_ns_ - anchor_ns_) + kJumpM;
    anchor_ns_ = now_ns_;
    anchor_m_ = sample.p_WD;
  }
  p_m_ = sample.p_WD;
  q_ = sample.q_WT;
  pose_ns_ = now_ns_;
  has_pose_ = true;
}

void GovernorEvaluator::receive(const HostileStep& step) noexcept {
  const bool is_accepted = governor_.counters().accepted != accepted_;
  accepted_ = governor_.counters().accepted;
  if (is_live_ && now_ns_ - accepted_ns_ >= kAgeLimitNs) is_live_ = was_open_ = false;
  if (step.command && !is_finite(step.command->wrench)) is_live_ = false;
  if (!is_accepted) return;
  is_live_ = true;
  accepted_ns_ = step.command->sample_time_ns;
}

void GovernorEvaluator::evaluate(const HostileStep& step, bool was_reset, const Wrench& out) noexcept {
  observe(step);
  advance_to(step.now_ns);
  is_current_ = has_pose_ && now_ns_ - pose_ns_ < kAgeLimitNs;
  const double passed_s = 1e-9 * static_cast<double>(now_ns_ - out_ns_);
  receive(step);
  breach_if(GovernorBreach::not_finite, !is_finite(out));
  check_size(out, passed_s);
  check_slew(out, passed_s);
  check_timeout(out);
  check_budgets(out, passed_s);
  check_workspace(out);
  check_latch(step, was_reset);
  check_gate(step, out, passed_s);
  out_ = out;
  out_ns_ = now_ns_;
}

void GovernorEvaluator::check_size(const Wrench& out, double passed_s) noexcept {
  const DeviceLimits& device = governor_.device_limits();
  const DeviceLimits& limits = governor_.limits();
  const double force = size_of(out.force_n);
  const double torque = size_of(out.torque_nm);
  const double released_n = size_of(out_.force_n) - device.max_slew_n_per_s * passed_s;
  const double released_nm = size_of(out_.torque_nm) - device.max_torque_slew_nm_per_s * passed_s;
  breach_if(GovernorBreach::force,
            force > with_tolerance(device.max_force_n) || force > with_tolerance(std::max(limits.max_force_n, released_n)));
  breach_if(GovernorBreach::torque,
            torque > with_tolerance(device.max_torque_nm) || torque > with_tolerance(std::max(limits.max_torque_nm, released_nm)));
  if (device.max_force_n > 0.0) worst_.force = std::max(worst_.force, force / device.max_force_n);
  if (device.max_torque_nm > 0.0) worst_.torque = std::max(worst_.torque, torque / device.max_torque_nm);
}

void GovernorEvaluator::check_slew(const Wrench& out, double passed_s) noexcept {
  const DeviceLimits& device = governor_.device_limits();
  const DeviceLimits& limits = governor_.limits();
  // slew: the tightened limit. release: that of the device. Only a change that does not increase the force may be faster than `slew`.
  const auto is_too_fast = [passed_s](const Vec3& from, const Vec3& to, double slew, double release) {
    const double change = size_of(to - from);
    return change > with_tolerance(release * passed_s) ||
           (change > with_tolerance(slew * passed_s) && size_of(to) > with_tolerance(size_of(from)));
  };
  breach_if(GovernorBreach::force_slew, is_too_fast(out_.force_n, out.force_n, limits.max_slew_n_per_s, device.max_slew_n_per_s));
  breach_if(GovernorBreach::torque_slew,
            is_too_fast(out_.torque_nm, out.torque_nm, limits.max_torque_slew_nm_per_s, device.max_torque_slew_nm_per_s));
  const auto share = [passed_s](const Vec3& from, const Vec3& to, double slew) {
    return slew > 0.0 && passed_s > 0.0 ? size_of(to - from) / (slew * passed_s) : 0.0;
  };
  worst_.force_slew = std::max(worst_.force_slew, share(out_.force_n, out.force_n, device.max_slew_n_per_s));
  worst_.torque_slew = std::max(worst_.torque_slew, share(out_.torque_nm, out.torque_nm, device.max_torque_slew_nm_per_s));
}

void GovernorEvaluator::check_timeout(const Wrench& out) noexcept {
  const bool has_timed_out = accepted_ == 0 || now_ns_ - accepted_ns_ >= kAgeLimitNs;
  breach_if(GovernorBreach::command_timeout, has_timed_out && (size_of(out.force_n) > 0.0 || size_of(out.torque_nm) > 0.0));
}

double GovernorEvaluator::energy_share() const noexcept {
  const double most_n = governor_.limits().max_force_n;
  return most_n > 0.0 ? std::clamp((kMaxEnergyM - spent_j_ / most_n) / (kMaxEnergyM - kFreeEnergyM), 0.0, 1.0) : 0.0;
}

void GovernorEvaluator::check_budgets(const Wrench& out, double passed_s) noexcept {
  const DeviceLimits& limits = governor_.limits();
  const double force = size_of(out.force_n);
  const double released_n = size_of(out_.force_n) - governor_.device_limits().max_slew_n_per_s * passed_s;
  if (time_constant_s_ > 0.0) {
    const double load = heat_n2_ / (limits.continuous_force_n * limits.continuous_force_n);
    const double continuous_n2 = limits.continuous_force_n * limits.continuous_force_n;
    const double max_n2 = limits.max_force_n * limits.max_force_n;
    const double allowed_n2 =
        load <= 0.8 || continuous_n2 >= max_n2 ? max_n2 : continuous_n2 + (max_n2 - continuous_n2) * std::max(0.0, (1.0 - load) / 0.2);
    // A wider tolerance than elsewhere, because the evaluator integrates the heat in other steps than the governor.
    breach_if(GovernorBreach::heat, force > std::max(std::sqrt(allowed_n2) * (1.0 + 1e-6), with_tolerance(released_n)));
    if (!has_stalled_ && is_physical_) {
      worst_.heat = std::max(worst_.heat, load);
      breach_if(GovernorBreach::heat, load > 1.02);
    }
  }
  breach_if(GovernorBreach::energy, force > std::max(limits.max_force_n * (energy_share() + 1e-6), with_tolerance(released_n)));
  if (is_physical_ && limits.max_force_n > 0.0) {
    // The bound includes the energy of the release after the last force: 10 ms at max_speed.
    const double most_j = kMaxEnergyM * limits.max_force_n +
                          0.010 * (limits.max_speed_m_per_s * limits.max_force_n + HostileProgram::kTurnRadPerS * limits.max_torque_nm);
    worst_.energy = std::max(worst_.energy, given_j_ / most_j);
    breach_if(GovernorBreach::energy, given_j_ > most_j);
  }
}

void GovernorEvaluator::check_workspace(const Wrench& out) noexcept {
  const DeviceLimits& limits = governor_.limits();
  const double slew = limits.max_slew_n_per_s;
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double sign = side % 2 == 0 ? 1.0 : -1.0;
    const double low = limits.workspace_min_m[axis];
    const double high = limits.workspace_max_m[axis];
    const double to_face_m = sign > 0.0 ? high - p_m_[axis] : p_m_[axis] - low;
    const double share = has_pose_ ? std::clamp(to_face_m / std::min(kWorkspaceMarginM, 0.1 * (high - low)), 0.0, 1.0) : 1.0;
    const double outward = sign * out.force_n[axis];
    const double before = sign * out_.force_n[axis];
    breach_if(GovernorBreach::workspace, outward > with_tolerance(std::max(limits.max_force_n * share, before)));
    if (share > 0.0 || slew <= 0.0) {
      sides_[side].shut_ns = -1;
      continue;
    }
    if (sides_[side].shut_ns < 0) sides_[side].shut_ns = now_ns_;
    // This bound holds however the goal changes: each step moves the force by slew x time, on a path of at most twice the force limit.
    const double time_s = 1e-9 * static_cast<double>(now_ns_ - sides_[side].shut_ns);
    const double most_n = governor_.device_limits().max_force_n;
    breach_if(GovernorBreach::workspace, outward > most_n * (std::exp(-slew * time_s / (2.0 * most_n)) + 1e-9));
  }
}

void GovernorEvaluator::check_latch(const HostileStep& step, bool was_reset) noexcept {
  const SafetyFault fault = governor_.fault();
  breach_if(GovernorBreach::unlatched, fault_ != SafetyFault::none && fault != fault_ && !was_reset);
  fault_ = fault;
  // A reset restarts all counts.
  if (was_reset) {
    bad_forces_ = bad_torques_ = bad_samples_ = {};
    anchor_ns_ = -1;
    is_too_fast_ = false;
  }
  const bool is_force_finite = !step.command || step.command->wrench.force_n.allFinite();
  const bool is_torque_finite = !step.command || !is_force_finite || step.command->wrench.torque_nm.allFinite();
  const bool is_device_present = step.status != DeviceStatus::away && step.status != DeviceStatus::calibrating;
  bool must_latch = step.status == DeviceStatus::fault || step.temperature >= 1.0 || has_jumped_ || is_too_fast_;
  must_latch = bad_forces_.is_too_long(!is_force_finite, now_ns_) || must_latch;
  must_latch = bad_torques_.is_too_long(!is_torque_finite, now_ns_) || must_latch;
  must_latch = (is_device_present && bad_samples_.is_too_long(!is_pose(step.sample), now_ns_)) || must_latch;
  breach_if(GovernorBreach::not_latched, must_latch && fault == SafetyFault::none);
}

bool GovernorEvaluator::ErrorRun::is_too_long(bool is_bad, std::int64_t now_ns) noexcept {
  if (count == 0) since_ns = now_ns;
  count = is_bad ? count + 1 : 0;
  return count >= 5 && now_ns - since_ns < 100'000'000;
}

void GovernorEvaluator::check_gate(const HostileStep& step, const Wrench& out, double passed_s) noexcept {
  const DeviceLimits& device = governor_.device_limits();
  const double force = size_of(out.force_n);
  const double before = size_of(out_.force_n);
  const double torque = size_of(out.torque_nm);
  const bool is_held = step.sample.is_held && (step.sample.buttons & buttons_) == buttons_;
  const bool is_device_present = step.status != DeviceStatus::away && step.status != DeviceStatus::calibrating;
  const bool is_open = is_held && is_device_present && is_current_ && is_live_ && fault_ == SafetyFault::none;
  if (is_open) {
    if (!was_open_) opened_ns_ = now_ns_;
    open_ns_ = now_ns_;
    const double most_n = governor_.limits().max_force_n;
    const bool may_damp = spent_j_ > kFreeEnergyM * most_n || governor_.speed_m_per_s() >= 0.6 * governor_.limits().max_speed_m_per_s;
    const double ramp = std::min(1.0, static_cast<double>(now_ns_ - opened_ns_) / static_cast<double>(kRampUpNs));
    breach_if(GovernorBreach::ramp, !may_damp && force > with_tolerance(std::max(ramp * most_n, before)));
  } else {
    const double released_n = std::max(0.0, before - device.max_slew_n_per_s * passed_s);
    const double released_nm = std::max(0.0, size_of(out_.torque_nm) - device.max_torque_slew_nm_per_s * passed_s);
    breach_if(GovernorBreach::gate, force > with_tolerance(released_n) || torque > with_tolerance(released_nm));
    const bool is_release = before > 0.0 && force == 0.0 && !has_stalled_;
    if (is_release) worst_.release_ms = std::max(worst_.release_ms, 1e-6 * static_cast<double>(now_ns_ - open_ns_));
  }
  was_open_ = is_open;
}

}  // namespace hapton
