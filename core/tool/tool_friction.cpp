#include "core/tool/tool_friction.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

// Of the device's motion: what moves the tool by less is no slide.
constexpr double kLeastPull = 0x1p-10;

// What friction takes from a slide: static and dynamic.
CoulombFriction find_loss(const LocalContacts& local, const LocalContacts::Held& held, const Vec6& slide) {
  CoulombFriction loss;
  for (int k = 0; k < held.active_count; ++k) {
    const auto i = static_cast<std::size_t>(held.active[k]);
    const LocalContact& contact = local.contacts[i];
    const Vec3 normal = local.bounds[i].row.head<3>();
    const Vec3 moved = slide.head<3>() + slide.tail<3>().cross(contact.arm);
    const double length = (moved - normal * normal.dot(moved)).norm();
    loss.friction_static += contact.friction.friction_static * held.multipliers[k] * length;
    loss.friction_dynamic += contact.friction.friction_dynamic * held.multipliers[k] * length;
  }
  return loss;
}

Vec6 motion_between(const Placement& from, const Placement& to) {
  Vec6 motion;
  motion << to.position - from.position, turn_between(from.orientation, to.orientation);
  return motion;
}

Placement displaced(const Placement& from, const Vec6& by) {
  return {from.position + by.head<3>(), (turn_by(by.tail<3>()) * from.orientation).normalized()};
}

}  // namespace

void ToolFriction::reset(const Placement& at) noexcept {
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

void ToolFriction::choose_carrier(const LocalContacts& local, const LocalContacts::Held& held, std::span<const Placement> parts) noexcept {
  carrier_ = 0;
  if (parts.empty()) return;
  double most = 0.0;
  for (int k = 0; k < held.active_count; ++k) {
    const LocalContact& own = local.contacts[static_cast<std::size_t>(held.active[k])];
    double sum = 0.0;
    for (int i = 0; i < held.active_count; ++i) {
      const LocalContact& other = local.contacts[static_cast<std::size_t>(held.active[i])];
      if (other.part == own.part) sum += other.friction.friction_static * held.multipliers[i];
    }
    if (sum <= most) continue;
    most = sum;
    carrier_ = own.part;
  }
  if (carrier_ > 0 && static_cast<std::size_t>(carrier_) <= parts.size()) carrier_at_ = parts[static_cast<std::size_t>(carrier_) - 1];
}

ToolFriction::Step ToolFriction::step(const LocalContacts& local, const Placement& device, std::span<const Placement> parts) noexcept {
  carry_along(parts);
  const LocalContacts::Held held = local.solve(device);
  choose_carrier(local, held, parts);
  const Vec6 moved = motion_between(std::exchange(device_, device), device);
  if (!is_placed_ || held.active_count == 0) {
    reset(held.at);
    return {held.at, device, false, held};
  }
  const Vec6 here = motion_between(local.proxy, at_);
  const Vec6 wanted = motion_between(local.proxy, device);
  const Vec6 slide = held.motion - here;
  const double pull = local.stiffness.cwiseProduct(wanted - here).dot(slide);
  const double bend = local.stiffness.cwiseProduct(slide).dot(slide);
  const CoulombFriction loss = find_loss(local, held, slide);
  double kept = 0.0;  // share of the slide that friction keeps the tool from
  if (sticks_ && pull <= loss.friction_static) {
    kept = 1.0;
  } else if (bend > 0.0) {
    kept = std::min(1.0, loss.friction_dynamic / bend);
  }
  const Vec6 pulled = local.stiffness.cwiseProduct(moved);
  const bool pulls_onward = pulled.dot(slide) > kLeastPull * pulled.dot(moved);
  const bool has_slid = bend > 0.0 && kept < 1.0;
  slides_ = has_slid || (slides_ && pulls_onward);
  sticks_ = kept >= 1.0 && loss.friction_static > 0.0 && !slides_;
  Step step;
  step.sticks = sticks_;
  step.held = held;
  step.goal = displaced(device, -kept * slide);
  // Where the tool was may be a little within contacts that were found since.
  const Vec6 motion = here + (1.0 - kept) * slide;
  step.at = local.constrain(displaced(local.proxy, motion));
  at_ = step.at;
  return step;
}

}  // namespace hapton
