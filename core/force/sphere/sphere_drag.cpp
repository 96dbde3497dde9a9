// A sphere's centre under Coulomb friction, from event to event: it sticks, slips and is dragged.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/contact_material.h"
#include "core/force/contact_qp.h"
#include "core/force/friction_drag.h"
#include "core/force/sphere/sphere_follower.h"
#include "core/math/find_zero.h"
#include "core/math/quadratic.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

using Part = OffsetContact::Part;
constexpr double kNever = std::numeric_limits<double>::infinity();
// A pull that leaves this much of a cone free or exceeds it by as much is on it: 4,096 times the rounding of a pull.
constexpr double kOnCone = 0x1p-40;
constexpr double kLeast = OffsetDrag::kLeastLag;
constexpr double kNearZero = 0x1p-51;  // of what passes zero: its rounding

}  // namespace

FrictionCoefficients SphereFollower::coefficients(const OffsetContact& contact) const noexcept {
  const Material& material = materials_[geometry_.mesh_of(contact.triangle)];
  return {material.friction_static, std::min(material.friction_dynamic, material.friction_static)};
}

bool SphereFollower::rubs() const noexcept {
  bool any = false;
  for (int i = 0; i < touching_; ++i) any |= coefficients(contacts_[i]).at_rest > 0.0;
  return any;
}

OffsetDrag SphereFollower::make_drag() noexcept {
  for (int i = 0; i < count_; ++i) rub_.coefficients[static_cast<std::size_t>(i)] = coefficients(contacts_[i]);
  const auto count = static_cast<std::size_t>(count_);
  return {std::span<const OffsetContact>(contacts_).first(count), std::span<const FrictionCoefficients>(rub_.coefficients).first(count),
          keep_.offset};
}

// Held where it is by a pull inside the cone. On the cone the device drags it on as soon as it moves.
SphereFollower::Next SphereFollower::hold(const OffsetDrag::Pull& pull) noexcept {
  const double cone = pull.friction.sliding * pull.depth;
  rub_.drags = rub_.slides && count_ < 3 && pull.length >= (1.0 - kOnCone) * cone - kLeast;
  rub_.slides = rub_.slides && pull.length >= FrictionMotion::kRestick * cone;
  rub_.slips = false;
  is_descending_ = false;
  return Next::again;
}

// With the device held: one piece of the way along the pull, until it is on the cone.
SphereFollower::Next SphereFollower::descend_rubbing(const Vec3& device, const Vec3& motion) noexcept {
  Vec3 way;
  if (!find_active(device - centre_, motion, way)) return Next::unclear;
  if (count_ == 0) {
    touching_ = 0;
    rub_.slips = false;
    ++idle_;
    return Next::again;
  }
  const OffsetDrag drag = make_drag();
  OffsetDrag::Pull pull;
  if (!drag.find_pull(centre_, device, pull)) return Next::unclear;
  const double held = (rub_.slides ? pull.friction.sliding : pull.friction.at_rest) * (1.0 + kOnCone) * pull.depth;
  const bool moves = count_ < 3 && (rub_.slips || pull.length * pull.length > held * held + kLeast * kLeast);
  if (!moves) return hold(pull);
  const bool has_vanished = rub_.slips && rub_.vanished;
  rub_ = {.slides = true, .coefficients = rub_.coefficients};
  Slip slip;
  if (!make_slip(drag, pull, device, has_vanished, slip)) return Next::unclear;
  if (slip.waits || slip.stands) {
    rub_.drags = true;
    is_descending_ = false;
    ++idle_;
    return slip.waits ? Next::wait : Next::again;
  }
  ++slips_;
  Event event;
  if (!find_event(slip.path, event)) return Next::unclear;
  const bool is_whole = event.time >= 1.0;
  const Vec3 before = centre_;
  bool is_restored = true;
  place_at_event(slip.path, event, [&](double share) {
    centre_ = slip.is_exact ? slip.path.at(share) : before;
    is_restored = slip.is_exact || share <= 0.0 || drag.descend(device, slip.way, share * slip.length, centre_, work_);
  });
  if (!is_restored) return Next::unclear;
  note_move(before);
  note_gain(device, false);
  if (is_whole && event.contact < 0 && event.slot < 0 && slip.stops) {
    rub_.drags = true;
    is_descending_ = false;
  }
  return take_event(event, slip.path) ? Next::again : Next::unclear;
}

// With the device moving, the pull on the cone: until the end of its motion, or the next event.
SphereFollower::Next SphereFollower::drag(const Vec3& from, const Vec3& to, double& time) noexcept {
  touching_ = count_;
  const OffsetDrag drag = make_drag();
  DragLeg leg;
  const bool is_round = count_ == 1 && contacts_[0].is_curved();
  const Dragged dragged = count_ == 3 ? Dragged::stops
                          : is_round  ? make_flow_leg(drag, from, to, time, leg)
                                      : make_drag_leg(drag, from, to, time, leg);
  if (dragged != Dragged::on) {
    ++idle_;
    rub_.drags = false;
    rub_.slips = dragged == Dragged::leaps;
    rub_.vanished = rub_.slips;
    is_descending_ = rub_.slips;
    return Next::again;
  }
  Event event;
  if (!find_event(leg.path, event)) return Next::unclear;
  const Vec3 before = centre_;
  const Vec3 device = on_path(from, to, time);
  const double was = time;
  const bool is_whole = event.time >= 1.0;
  bool is_restored = true;
  place_at_event(leg.path, event, [&](double share) {
    time = share >= 1.0 ? leg.time : leg.is_exact ? leg.time_at(was, share) : was + share * (leg.time - was);
    centre_ = leg.path.at(share);
    if (share >= 1.0 || leg.is_exact) return;
    if (leg.flow > 0.0) {
      OffsetDrag::Flow at{before, was};
      if (drag.flow(from, to, share * leg.flow, at, work_)) {
        centre_ = at.centre;
        time = std::clamp(at.time, was, leg.time);
      } else {
        is_restored = restore(centre_);
      }
      return;
    }
    Vec3 c = before;
    if (drag.follow(device, on_path(from, to, time), c, work_)) {
      centre_ = c;
    } else {
      is_restored = restore(centre_);
    }
  });
  if (!is_restored) return Next::unclear;
  note_move(before);
  if ((time - was) * (to - from).norm() > kStill) note_gain(on_path(from, to, time), true);
  if (const auto next = end_leg(leg.path, event, is_whole, leg.released, on_path(from, to, time))) return *next;
  if (leg.stops) rub_.drags = false;
  if (leg.leaps) {
    rub_.slips = true;
    rub_.vanished = true;
    is_descending_ = true;
    return Next::again;
  }
  return time >= 1.0 ? Next::settled : Next::again;
}

// The pull on a centre that stays, held by what it touches, against the cone.
SphereFollower::Held SphereFollower::find_held(const Vec3& pull) const noexcept {
  Held now;
  std::array<ContactPlane, kMostContacts> planes;
  for (int i = 0; i < touching_; ++i) planes[static_cast<std::size_t>(i)] = {contacts_[i].stand(centre_).normal, 0.0};
  const ConstrainedMotion held = constrain_motion(pull, std::span<const ContactPlane>(planes.data(), static_cast<std::size_t>(touching_)));
  if (!held.solved) return now;
  ContactMaterial material;
  for (int i = 0; i < held.active_count; ++i) {
    material.add(materials_[geometry_.mesh_of(contacts_[held.active[i]].triangle)], held.multipliers[i]);
  }
  now.is_free = held.active_count == 0;
  now.friction = {material.mean().friction_static, std::min(material.mean().friction_static, material.mean().friction_dynamic)};
  now.way = held.active_count == 3 ? 0.0 : held.motion.norm();
  now.depth = (pull - held.motion).norm();
  now.is_known = true;
  return now;
}

// Until the pull leaves the cone of what holds the centre. For each contact, and each two, that is a quadratic in time; it is the event if
// they hold the centre then.
SphereFollower::Next SphereFollower::stay_rubbing(const Vec3& from, const Vec3& to, double& time) noexcept {
  const Vec3 start = on_path(from, to, time) - centre_;
  const Vec3 motion = (1.0 - time) * (to - from);
  const auto excess_at = [&](double t) {
    const Vec3 pull = t < 1.0 ? Vec3(start + t * motion) : Vec3(to - centre_);
    const Held now = find_held(pull);
    if (!now.is_known) return -1.0;
    if (now.is_free) return pull.norm();
    return now.way - (rub_.slides ? now.friction.sliding : now.friction.at_rest) * now.depth;
  };
  const auto lag_at = [&](double t) {
    const Held now = find_held(start + t * motion);
    return now.is_known && !now.is_free ? FrictionMotion::kRestick * now.friction.sliding * now.depth - now.way : -1.0;
  };
  double soonest = kNever;
  double rest = kNever;
  const auto consider = [&](double t) {
    if (!(t < soonest) || !(t <= 1.0)) return;
    const Vec3 pull = start + t * motion;
    if (excess_at(t) >= -(4.0 * kOnCone * pull.norm() + 2.0 * kLeast)) soonest = t;
  };
  const auto consider_rest = [&](double t) {
    if (!rub_.slides || !(t < rest) || !(t < 1.0)) return;
    if (lag_at(t) >= -(4.0 * kOnCone * (start + t * motion).norm())) rest = t;
  };
  const double squared[3] = {motion.squaredNorm(), start.dot(motion), start.squaredNorm()};
  // of_square |pull|^2 + of_part (direction . pull)^2 - bound
  const auto rise = [&](double of_square, const Vec3& direction, double of_part, double bound) {
    const double rate = direction.dot(motion);
    const double height = direction.dot(start);
    // Well above zero now, it is not of what holds the centre now.
    const double now = of_square * squared[2] + of_part * height * height - bound;
    const bool is_above = now > 8.0 * kOnCone * squared[2] + 4.0 * kLeast * start.norm();
    const double t = time_of_rise(of_square * squared[0] + of_part * rate * rate, of_square * squared[1] + of_part * rate * height, now,
                                  2.0 * kOnCone * squared[2]);
    return is_above && t == 0.0 ? kNever : t;
  };
  const auto consider_cone = [&](const Vec3& normal, const FrictionCoefficients& friction) {
    const double held = rub_.slides ? friction.sliding : friction.at_rest;
    const double least = FrictionMotion::kRestick * friction.sliding;
    consider(rise(1.0, normal, -(1.0 + held * held), kLeast * kLeast));
    if (rub_.slides) consider_rest(rise(-1.0, normal, 1.0 + least * least, 0.0));
  };
  if (excess_at(0.0) > 4.0 * kOnCone * start.norm() + 2.0 * kLeast) soonest = 0.0;
  for (int i = 0; i < touching_; ++i) {
    ++work_;
    const Vec3 normal = contacts_[i].stand(centre_).normal;
    const FrictionCoefficients friction = coefficients(contacts_[i]);
    consider_cone(normal, friction);
    const double height = normal.dot(start);
    const double there = normal.dot(start + motion);
    if (height < 0.0 && there > 0.0) consider(height / (height - there));
    for (int j = i + 1; j < touching_; ++j) {
      const Vec3 line = accurate_cross(normal, contacts_[j].stand(centre_).normal);
      if (!(line.norm() > 0x1p-40)) continue;
      const Vec3 along = line.normalized();
      const FrictionCoefficients other = coefficients(contacts_[j]);
      for (const FrictionCoefficients& f : {friction, other}) {
        const double held = rub_.slides ? f.sliding : f.at_rest;
        const double least = FrictionMotion::kRestick * f.sliding;
        consider(rise(-held * held, along, 1.0 + held * held, kLeast * kLeast));
        if (rub_.slides) consider_rest(rise(least * least, along, -(1.0 + least * least), 0.0));
      }
    }
  }
  // Where materials differ the cone of two is none of these: it is searched for.
  if (!(soonest <= 1.0)) {
    const double end = excess_at(1.0);
    const double tolerance = 4.0 * kOnCone * (start.norm() + motion.norm()) + 2.0 * kLeast;
    if (end > tolerance)
      soonest = find_zero(0.0, std::max(0.0, -excess_at(0.0)), 1.0, -end, kNearZero, [&](double t) { return -excess_at(t); });
  }
  const double first = std::min({soonest, rest, 1.0});
  ++idle_;
  if (first * motion.norm() > kStill) idle_ = 0;
  least_distance_ = kNever;
  time = first >= 1.0 ? 1.0 : time + first * (1.0 - time);
  if (soonest <= 1.0 && soonest <= rest) {
    rub_.slips = true;
    rub_.vanished = false;
    is_descending_ = true;
    return Next::again;
  }
  if (rest < 1.0) {
    rub_.slides = false;
    return Next::again;
  }
  Vec3 way;
  return find_active(to - centre_, to - from, way) ? Next::settled : Next::unclear;
}

}  // namespace hapton
