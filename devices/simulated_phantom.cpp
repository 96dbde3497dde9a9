#include "devices/simulated_phantom.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "devices/model_a.h"

namespace hapton {

namespace {

static_assert(HandScript::kMaxAims == Device::kMaxAims);

constexpr double kHandTurnRadPerS = 2.0;  // about each axis: a third of a turn a second, as a hand turns a nut
constexpr double kGimbalStepRad = 2.0 * std::numbers::pi / model_a::kGimbalCounts;

Vec3 start_of(const DeviceLimits& limits) { return {0.0, 0.0, 0.9 * limits.workspace_max_m.z()}; }

HandScript::Options script_options(const DeviceLimits& limits, const SimulatedPhantom::Options& options) {
  return {options.seed, limits.workspace_min_m, limits.workspace_max_m, start_of(limits), options.path, options.repeat_path};
}

double to_grid(double value, double step) { return std::round(value / step) * step; }

}  // namespace

SimulatedPhantom::SimulatedPhantom(const Options& options)
    : limits_(options.has_torque ? model_a::limits_with_torque() : model_a::limits()),
      dynamics_(options.stylus),
      script_(script_options(limits_, options)),
      hand_m_(start_of(limits_)),
      has_torque_(options.has_torque) {
  for (int axis = 0; axis < 3; ++axis) axes_[axis] = {hand_m_[axis], 0.0, hand_m_[axis], 0.0};
}

Vec3 SimulatedPhantom::exact_position_m() const noexcept { return {axes_[0].device_m, axes_[1].device_m, axes_[2].device_m}; }

bool SimulatedPhantom::set_hand_target(const std::optional<Vec3>& p_WH) noexcept {
  script_.lead(p_WH);
  return true;
}

bool SimulatedPhantom::press_hand_buttons(std::uint32_t buttons) noexcept {
  pressed_buttons_ = buttons;
  return true;
}

bool SimulatedPhantom::turn_hand(const Vec3& turn_rad) noexcept {
  if (!turn_rad.allFinite()) return true;
  turn_goal_rad_ = turn_rad;
  if (turn_rad.isZero(0.0)) turn_rad_ = turn_rad_.unaryExpr([](double rad) { return std::remainder(rad, 2.0 * std::numbers::pi); });
  return true;
}

bool SimulatedPhantom::aim_hand(std::span<const Vec3> p_WA) noexcept {
  script_.aim(p_WA);
  return true;
}

void SimulatedPhantom::begin_hand_step() noexcept {
  const HandIntention next = script_.step(exact_position_m(), force_n_);
  hand_m_per_s_ = (next.p_WH - hand_m_) * (1e9 / static_cast<double>(HandScript::kStepNs));
  constexpr double kMaxTurn = kHandTurnRadPerS * 1e-9 * static_cast<double>(HandScript::kStepNs);
  turn_rad_ += (turn_goal_rad_ - turn_rad_).cwiseMax(-kMaxTurn).cwiseMin(kMaxTurn);
  gimbal_rad_ = next.gimbal_rad + turn_rad_;
  q_WH_ = next.q_WT;
  buttons_ = next.buttons;
}

// Rounds the gimbal angles to encoder steps; an orientation from a path is not rounded.
Quat SimulatedPhantom::target_orientation() const noexcept {
  const auto turn_by_gimbals = [](const Vec3& rad) {
    return Quat(Eigen::AngleAxisd(rad.x(), Vec3::UnitY()) * Eigen::AngleAxisd(rad.y(), Vec3::UnitX()) *
                Eigen::AngleAxisd(rad.z(), Vec3::UnitZ()));
  };
  if (q_WH_) return turn_rad_.isZero(0.0) ? *q_WH_ : *q_WH_ * turn_by_gimbals(turn_rad_);
  return turn_by_gimbals(gimbal_rad_.unaryExpr([](double rad) { return to_grid(rad, kGimbalStepRad); }));
}

void SimulatedPhantom::advance_to(std::int64_t now_ns) noexcept {
  if (device_ns_ < 0) {
    zero_ns_ = now_ns;
    device_ns_ = 0;
    begin_hand_step();
    turn_.begin_at(target_orientation());
  }
  const bool is_cut = is_cut_.load(std::memory_order_acquire) || (heartbeat_page_ != nullptr && heartbeat_page_->is_cut.load() != 0);
  force_n_ = is_cut ? Vec3(Vec3::Zero()) : written_n_;
  torque_nm_ = is_cut ? Vec3(Vec3::Zero()) : written_nm_;
  zero_ns_ += std::max<std::int64_t>(0, now_ns - zero_ns_ - device_ns_ - kLongestPauseNs);
  const std::int64_t end_ns = now_ns - zero_ns_;
  while (device_ns_ < end_ns) {
    const std::int64_t hand_step_end_ns = (device_ns_ / HandScript::kStepNs + 1) * HandScript::kStepNs;
    const std::int64_t next_ns = std::min(end_ns, hand_step_end_ns);
    for (int axis = 0; axis < 3; ++axis) {
      dynamics_.advance(axes_[axis], {force_n_[axis], hand_m_[axis], hand_m_per_s_[axis]},
                        {limits_.workspace_min_m[axis], limits_.workspace_max_m[axis]}, device_ns_, next_ns - device_ns_);
    }
    if (has_torque_) turn_.advance(device_ns_, next_ns, target_orientation(), torque_nm_);
    hand_m_ += hand_m_per_s_ * (1e-9 * static_cast<double>(next_ns - device_ns_));
    device_ns_ = next_ns;
    if (next_ns == hand_step_end_ns) begin_hand_step();
  }
}

DeviceSample SimulatedPhantom::read(std::int64_t now_ns) noexcept {
  advance_to(now_ns);
  const Vec3 exact_m = exact_position_m();
  DeviceSample sample;
  sample.time_ns = now_ns;
  for (int axis = 0; axis < 3; ++axis) sample.p_WD[axis] = to_grid(exact_m[axis], model_a::kPositionStepM);
  sample.buttons = buttons_ | pressed_buttons_;
  sample.q_WT = has_torque_ ? turn_.q_WT() : target_orientation();
  return sample;
}

void SimulatedPhantom::write(const Wrench& wrench, std::int64_t now_ns) noexcept {
  advance_to(now_ns);
  written_n_ = wrench.force_n;
  written_nm_ = has_torque_ ? wrench.torque_nm : Vec3(Vec3::Zero());
  for (std::size_t axis = 0; heartbeat_page_ != nullptr && axis < 3; ++axis)
    heartbeat_page_->motors_n[axis].store(written_n_[static_cast<Eigen::Index>(axis)]);
}

}  // namespace hapton
