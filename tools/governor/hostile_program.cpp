#include "tools/governor/hostile_program.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace hapton {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kExtremeValues[] = {
    kNan,    kInf, -kInf,  1e300, -1e300, std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest(), 5e-324,
    -5e-324, 1e9,  -1e154, 0.0,   -0.0};
// Mass of device and hand, stiffness and damping of the hand: within the ranges of a stylus grip (docs/loop.md).
constexpr double kMassKg = 0.15;
constexpr double kHandNPerM = 300.0;
constexpr double kHandNSPerM = 4.0;
constexpr std::int64_t kHourNs = 3'600'000'000'000;  // how far the program's clock jumps back or ahead

}  // namespace

// The shares of chance and the ranges in this file are free choices; a change changes every program.
HostileProgram::HostileProgram(std::uint64_t seed) noexcept : random_(seed) {
  is_physical_ = random_.once_in(4);
  choose_device();
  turns_ = static_cast<int>(200 + random_.below(4000));
  is_regular_in_time_ = is_physical_ || random_.once_in(2);
  is_regular_in_motion_ = is_physical_ || random_.once_in(2);
  is_regular_in_state_ = random_.once_in(2);
  button_ = random_.once_in(4) ? static_cast<int>(random_.below(34)) : 0;
  period_ns_ = std::llround(1e9 / std::pow(10.0, random_.uniform(std::log10(250.0), 4.0)));
  clock_ns_ = random_.once_in(10) ? -kHourNs : static_cast<std::int64_t>(random_.below(1'000'000'000'000'000));
  step_.sample.buttons = ~0U;
}

// Chooses limits like those of devices on the market and of devices that do not exist; sometimes one value is impossible.
void HostileProgram::choose_device() noexcept {
  device_.max_force_n = std::pow(10.0, random_.uniform(-1.0, 2.0));
  device_.max_slew_n_per_s = device_.max_force_n / random_.uniform(0.001, 0.05);
  device_.max_stiffness_n_per_m = random_.once_in(4) ? 0.0 : random_.uniform(100.0, 3000.0);
  const Vec3 half = Vec3(random_.uniform(0.02, 0.4), random_.uniform(0.02, 0.4), random_.uniform(0.02, 0.4));
  device_.workspace_min_m = -half;
  device_.workspace_max_m = half;
  if (random_.once_in(8)) device_.workspace_max_m[static_cast<int>(random_.below(3))] = kNan;
  if (!random_.once_in(3)) {
    device_.max_torque_nm = std::pow(10.0, random_.uniform(-3.0, 0.5));
    device_.max_torque_slew_nm_per_s = random_.once_in(4) ? 0.0 : device_.max_torque_nm / random_.uniform(0.001, 0.05);
  }
  if (!random_.once_in(3)) {
    device_.continuous_force_n = device_.max_force_n * random_.uniform(0.1, 0.9);
    // A peak time that is shorter than a release cannot be kept without a jump of the force: the governor then latches a fault.
    device_.peak_s = std::pow(10.0, random_.uniform(is_physical_ ? -0.5 : -2.0, 1.0));
  }
  device_.max_speed_m_per_s = random_.once_in(4) ? 0.0 : random_.uniform(0.3, 4.0);
  if (random_.once_in(50)) device_.max_slew_n_per_s = extreme_value();
  if (random_.once_in(50)) device_.max_force_n = extreme_value();
  if (random_.once_in(50)) device_.continuous_force_n = extreme_value();
}

double HostileProgram::extreme_value() noexcept { return kExtremeValues[random_.below(std::size(kExtremeValues))]; }

void HostileProgram::choose_phase() noexcept {
  remaining_turns_ = static_cast<int>(5 + random_.below(200));
  force_ = static_cast<Force>(random_.below(static_cast<std::uint64_t>(Force::count)));
  // This force is rare, because the fault that follows latches and hides everything else.
  if (force_ == Force::extreme && !random_.once_in(3)) force_ = Force::active;
  const auto regular_motions = static_cast<std::uint64_t>(Motion::fast);
  motion_ = static_cast<Motion>(
      random_.below(is_regular_in_motion_ || !random_.once_in(4) ? regular_motions : static_cast<std::uint64_t>(Motion::count)));
  if (is_physical_) motion_ = Motion::mass;
  time_ = is_regular_in_time_ || random_.once_in(2) ? static_cast<Time>(random_.below(2))
                                                    : static_cast<Time>(random_.below(static_cast<std::uint64_t>(Time::count)));
  axis_ = random_.vector(1.0) + Vec3(1e-3, 0, 0);
  axis_.normalize();
  hertz_ = std::pow(10.0, random_.uniform(-0.5, 2.5));
  turn_rad_per_s_ = random_.vector(kTurnRadPerS / 2.0);
  hand_m_per_s_ = random_.once_in(2) ? Vec3(Vec3::Zero()) : random_.vector(0.3);
}

void HostileProgram::advance_time() noexcept {
  std::int64_t passed_ns = period_ns_;
  if (time_ != Time::steady) passed_ns = static_cast<std::int64_t>(static_cast<double>(period_ns_) * random_.uniform(0.0, 2.0));
  if (time_ == Time::stall && random_.once_in(20)) passed_ns = static_cast<std::int64_t>(random_.below(400'000'000));
  clock_ns_ += passed_ns;
  passed_s_ = 1e-9 * static_cast<double>(passed_ns);
  step_.sample.time_ns = step_.now_ns = clock_ns_;
  step_.now_ns += static_cast<std::int64_t>(random_.below(static_cast<std::uint64_t>(period_ns_ / 2)));
  if (time_ == Time::jump && random_.once_in(100)) {
    clock_ns_ += random_.once_in(3) ? kHourNs : static_cast<std::int64_t>(random_.below(2'000'000'000));
    if (random_.once_in(10)) step_.now_ns = std::numeric_limits<std::int64_t>::max();
  }
  if (time_ == Time::back && random_.once_in(5)) {
    const std::int64_t back_ns = random_.once_in(4) ? kHourNs : static_cast<std::int64_t>(random_.below(30'000'000));
    (random_.once_in(2) ? step_.now_ns : step_.sample.time_ns) -= back_ns;
    if (random_.once_in(20)) step_.now_ns = std::numeric_limits<std::int64_t>::min();
  }
}

// Moves a mass on which the force acts, and which a moving hand pulls by a soft spring. The mass stays within about 0.5 m of the origin.
void HostileProgram::move_mass(const Vec3& force_n, double passed_s) noexcept {
  hand_m_ += hand_m_per_s_ * passed_s;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(hand_m_[axis]) > 0.2) hand_m_per_s_[axis] = -std::copysign(hand_m_per_s_[axis], hand_m_[axis]);
  }
  constexpr int kParts = 4;  // number of parts in which a step is integrated; a free choice
  const double h = passed_s / kParts;
  for (int part = 0; part < kParts; ++part) {
    const Vec3 pull_n = kHandNPerM * (hand_m_ - p_m_) + kHandNSPerM * (hand_m_per_s_ - v_m_per_s_);
    v_m_per_s_ += (force_n + pull_n) * (h / kMassKg);
    p_m_ += v_m_per_s_ * h;
  }
}

void HostileProgram::move(const Wrench& out) noexcept {
  const double passed_s = std::min(passed_s_, 0.02);
  const double speed = device_.max_speed_m_per_s > 0.0 ? device_.max_speed_m_per_s : 2.0;
  const double size = out.force_n.norm();
  const double phase = 2.0 * std::numbers::pi * hertz_ * 1e-9 * static_cast<double>(clock_ns_ % kHourNs);
  const Vec3 before = p_m_;
  switch (motion_) {
    case Motion::mass:
      move_mass(out.force_n, passed_s);
      break;
    case Motion::still:
    case Motion::count:
      break;
    case Motion::sweep:
      p_m_ += axis_ * (0.5 * speed * std::cos(0.02 * phase) * passed_s);
      break;
    case Motion::yielding:  // moves along the force
      if (size > 0.0) p_m_ += out.force_n * (random_.uniform(0.0, 0.7) * speed * passed_s / size);
      break;
    case Motion::noise:
      p_m_ += random_.vector(0.3 * speed * passed_s);
      break;
    case Motion::fast:
      p_m_ += axis_ * (random_.uniform(0.5, 1.5) * speed * passed_s);
      break;
    case Motion::jump:
      if (random_.once_in(30)) p_m_ = random_.vector(random_.once_in(10) ? 1e5 : 0.3);
      if (random_.once_in(30)) q_ = Quat(Eigen::AngleAxisd(random_.uniform(-3.0, 3.0), axis_));
      break;
    case Motion::extreme:
      break;
  }
  for (int axis = 0; axis < 3; ++axis) {
    // A position that is too far out is moved back slowly.
    if (std::abs(p_m_[axis]) > 0.45 && motion_ != Motion::jump && std::abs(p_m_[axis]) < 1.0)
      p_m_[axis] -= std::copysign(0.2 * speed * passed_s, p_m_[axis]);
  }
  if (motion_ != Motion::mass && passed_s > 0.0) v_m_per_s_ = (p_m_ - before) / passed_s;
  step_.sample.p_WD = p_m_;
  const Vec3 half_turn = 0.5 * passed_s * turn_rad_per_s_;
  q_ = (Quat(1.0, half_turn.x(), half_turn.y(), half_turn.z()) * q_).normalized();
  step_.sample.q_WT = q_;
  if (motion_ == Motion::extreme && random_.once_in(3)) {
    step_.sample.p_WD[static_cast<int>(random_.below(3))] = extreme_value();
    if (random_.once_in(4)) step_.sample.q_WT.w() = extreme_value();
  }
}

void HostileProgram::choose_state() noexcept {
  step_.tighter_limits.reset();
  step_.resets_faults = false;
  step_.temperature = -1.0;
  if (random_.once_in(300)) step_.resets_faults = true;
  if (is_physical_) return;
  if (random_.once_in(2000)) {
    DeviceLimits tighter;
    tighter.max_force_n = random_.once_in(4) ? extreme_value() : device_.max_force_n * random_.uniform(0.2, 3.0);
    tighter.max_slew_n_per_s = random_.once_in(4) ? extreme_value() : device_.max_slew_n_per_s * random_.uniform(0.2, 3.0);
    tighter.max_torque_nm = device_.max_torque_nm * random_.uniform(0.2, 3.0);
    tighter.continuous_force_n = device_.max_force_n * random_.uniform(0.1, 3.0);
    tighter.max_speed_m_per_s = random_.uniform(0.1, 10.0);
    tighter.workspace_min_m = -Vec3::Constant(random_.uniform(0.01, 1.0));
    tighter.workspace_max_m = Vec3::Constant(random_.uniform(0.01, 1.0));
    step_.tighter_limits = tighter;
  }
  if (is_regular_in_state_) return;
  if (random_.once_in(50)) step_.status = random_.once_in(2) ? DeviceStatus::ready : static_cast<DeviceStatus>(random_.below(5));
  if (step_.status == DeviceStatus::fault && random_.once_in(5)) step_.status = DeviceStatus::ready;
  if (random_.once_in(40)) step_.sample.is_held = !random_.once_in(4);
  if (random_.once_in(40)) step_.sample.buttons = random_.once_in(4) ? static_cast<std::uint32_t>(random_.bits()) : ~0U;
  if (random_.once_in(500)) step_.temperature = random_.uniform(0.0, 1.05);
}

Vec3 HostileProgram::command_force_n(double most) noexcept {
  const double time_s = 1e-9 * static_cast<double>(clock_ns_ % kHourNs);
  switch (force_) {
    case Force::none:
    case Force::replay:
    case Force::count:
      return Vec3::Zero();
    case Force::spring:  // a wall through the middle
      return axis_ * std::clamp(-1000.0 * axis_.dot(p_m_), 0.0, most);
    case Force::active:  // accelerates the motion
      return v_m_per_s_ * (most / (0.01 + v_m_per_s_.norm()));
    case Force::most:
      return axis_ * most;
    case Force::sine:
      return axis_ * (most * std::sin(2.0 * std::numbers::pi * hertz_ * time_s));
    case Force::noise:
      return random_.vector(most);
    case Force::nyquist:
      return axis_ * (turn_ % 2 == 0 ? most : -most);
    case Force::huge:
      return axis_ * (turn_ % 2 == 0 ? 1e300 : -1e300);
    case Force::tiny:
      return axis_ * 1e-310;
    case Force::extreme: {
      Vec3 force = random_.vector(most);
      if (random_.once_in(2)) force[static_cast<int>(random_.below(3))] = extreme_value();
      return force;
    }
  }
  return Vec3::Zero();
}

void HostileProgram::choose_command() noexcept {
  step_.command.reset();
  if (force_ == Force::none || random_.once_in(20)) return;
  WrenchCommand& command = sent_commands_[static_cast<std::size_t>(turn_) % sent_commands_.size()];
  if (force_ == Force::replay) {
    step_.command = sent_commands_[random_.below(sent_commands_.size())];
    return;
  }
  const double most = std::isfinite(device_.max_force_n) ? std::abs(device_.max_force_n) * 1.2 : 10.0;
  command.wrench.force_n = command_force_n(most);
  command.wrench.torque_nm = random_.vector(2.0 * device_.max_torque_nm);
  if (force_ == Force::extreme && random_.once_in(8)) command.wrench.torque_nm.x() = extreme_value();
  command.sample_time_ns = step_.sample.time_ns;
  if (random_.once_in(10)) command.sample_time_ns -= static_cast<std::int64_t>(random_.below(25'000'000));
  if (random_.once_in(200)) command.sample_time_ns = static_cast<std::int64_t>(random_.bits());
  step_.command = command;
}

const HostileStep& HostileProgram::turn(const Wrench& out) noexcept {
  if (--remaining_turns_ <= 0) choose_phase();
  ++turn_;
  advance_time();
  move(out);
  choose_state();
  choose_command();
  return step_;
}

}  // namespace hapton
