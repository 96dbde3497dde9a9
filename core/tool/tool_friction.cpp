#include "core/tool/tool_friction.h"

#include <algorithm>

namespace hapton {
namespace {

// What friction takes from a slide: static and dynamic.
SurfaceFriction find_loss(const LocalContacts& local, const LocalContacts::Held& held, const Vec6& slide) {
  SurfaceFriction loss;
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

Placement displaced(const Placement& from, const Vec6& by) {
  return {from.position + by.head<3>(), (turn_by(by.tail<3>()) * from.orientation).normalized()};
}

}  // namespace

void ToolFriction::reset(const Placement& at) noexcept {
  at_ = at;
  is_placed_ = true;
  sticks_ = false;
}

ToolFriction::Step ToolFriction::step(const LocalContacts& local, const Placement& device) noexcept {
  const LocalContacts::Held held = local.solve(device);
  if (!is_placed_ || held.active_count == 0) {
    reset(held.at);
    return {held.at, device, false};
  }
  Vec6 here;
  here << at_.position - local.proxy.position, turn_between(local.proxy.orientation, at_.orientation);
  Vec6 wanted;
  wanted << device.position - local.proxy.position, turn_between(local.proxy.orientation, device.orientation);
  const Vec6 slide = held.motion - here;
  const double pull = local.stiffness.cwiseProduct(wanted - here).dot(slide);
  const double bend = local.stiffness.cwiseProduct(slide).dot(slide);
  const SurfaceFriction loss = find_loss(local, held, slide);
  double kept = 0.0;  // share of the slide that friction keeps the tool from
  if (sticks_ && pull <= loss.friction_static) {
    kept = 1.0;
  } else if (bend > 0.0) {
    kept = std::min(1.0, loss.friction_dynamic / bend);
  }
  sticks_ = kept >= 1.0 && loss.friction_static > 0.0;
  Step step;
  step.sticks = sticks_;
  step.goal = displaced(device, -kept * slide);
  // Where the tool was may be a little within contacts that were found since.
  const Vec6 motion = here + (1.0 - kept) * slide;
  step.at = local.constrain(displaced(local.proxy, motion));
  at_ = step.at;
  return step;
}

}  // namespace hapton
