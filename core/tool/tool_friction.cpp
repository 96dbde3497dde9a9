#include "core/tool/tool_friction.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

// Share of the device's motion: if, without friction, the tool would move by no more along it, the device does not pull the tool onward.
constexpr double kMinPull = 0x1p-10;
// Share of the device's motion: a tool that sticks moves by at most this. One that slides moves by all of it.
constexpr double kMaxStickShare = 0.125;
// Share of the distance between device and tool: the slip that the iteration leaves, 16 times the correction that ends it (ContactCones).
constexpr double kResidualSlipShare = 0x1p-16;

// Largest rotation in a step, rad, of a tool that was in contact. Where friction has turned it far from the device, the bounds of contacts,
// which are linear about the tool's pose, do not hold along the path back: the next step continues with contacts found on that path. 100
// rad/s at 1 kHz, twice as fast as a hand turns.
constexpr double kMaxTurn = 0.1;

Placement displaced(const Placement& from, const Vec6& by) {
  return {from.position + by.head<3>(), (turn_by(by.tail<3>()) * from.orientation).normalized()};
}

}  // namespace

void ToolFriction::reset(const Placement& at) noexcept {
  cones_.forget();
  at_ = at;
  is_placed_ = true;
  sticks_ = slides_ = false;
}

void ToolFriction::carry_along(std::span<const Placement> parts) noexcept {
  const auto carrier = static_cast<std::size_t>(carrier_);
  if (carrier_ <= 0 || carrier > parts.size() || parts[carrier - 1] == carrier_at_) return;
  const Placement moved = parts[carrier - 1] * carrier_at_.inverse();
  at_ = moved * at_;
  device_ = moved * device_;
}

void ToolFriction::choose_carrier(const LocalContacts& local, const LocalContacts::Solution& solution,
                                  std::span<const Placement> parts) noexcept {
  carrier_ = 0;
  if (parts.empty()) return;
  double most = 0.0;
  for (int k = 0; k < solution.active_count; ++k) {
    const LocalContact& contact = local.contacts[static_cast<std::size_t>(solution.active[k])];
    double sum = 0.0;
    for (int i = 0; i < solution.active_count; ++i) {
      const LocalContact& other = local.contacts[static_cast<std::size_t>(solution.active[i])];
      if (other.part == contact.part) sum += other.friction.friction_static * solution.multipliers[i];
    }
    if (sum <= most) continue;
    most = sum;
    carrier_ = contact.part;
  }
  if (carrier_ > 0 && static_cast<std::size_t>(carrier_) <= parts.size()) carrier_at_ = parts[static_cast<std::size_t>(carrier_) - 1];
}

ToolFriction::Step ToolFriction::step(const LocalContacts& local, const Placement& device, std::span<const Placement> parts) noexcept {
  carry_along(parts);
  const LocalContacts::Solution solution = local.solve(device);
  choose_carrier(local, solution, parts);
  const Vec6 moved = motion_between(std::exchange(device_, device), device).shift_and_turn();
  const bool was_held = is_placed_ && cones_.holds() && !local.is_blocked;
  if (solution.active_count == 0 && was_held && turn_between(at_.orientation, solution.at.orientation).norm() > kMaxTurn) {
    const Vec6 back = motion_between(at_, solution.at).shift_and_turn();
    at_ = displaced(at_, (kMaxTurn / back.tail<3>().norm()) * back);
    return {at_, at_, solution};
  }
  if (!is_placed_ || solution.active_count == 0) {
    reset(solution.at);
    return {solution.at, device, solution};
  }
  const Vec6 present_motion = motion_between(local.proxy, at_).shift_and_turn();
  const Vec6 wanted = motion_between(local.proxy, device).shift_and_turn();
  const Vec6 slide = solution.motion - present_motion;
  cones_.solve(local, wanted, present_motion, solution, sticks_);
  const double moved_length = moved.head<3>().norm() + std::sqrt(local.stiffness[3]) * moved.tail<3>().norm();
  const Vec6 extension = wanted - cones_.motion();
  const double residual_slip = kResidualSlipShare * std::sqrt(local.stiffness.cwiseProduct(extension).dot(extension));
  const bool slides = cones_.slip() > std::max({kMaxStickShare * moved_length, residual_slip, local.tolerance});
  const Vec6 pull_change = local.stiffness.cwiseProduct(moved);
  const bool pulls_onward = pull_change.dot(slide) > kMinPull * pull_change.dot(moved);
  slides_ = slides || (slides_ && pulls_onward);
  sticks_ = !slides && !slides_;
  Step step;
  step.solution = solution;
  const Vec6 ahead = cones_.motion() - present_motion;
  const double turn = ahead.tail<3>().norm();
  const Vec6 motion = was_held && turn > kMaxTurn ? Vec6(present_motion + (kMaxTurn / turn) * ahead) : cones_.motion();
  step.at = displaced(local.proxy, local.project(motion));
  at_ = step.goal = step.at;
  return step;
}

}  // namespace hapton
