// A sphere's centre under Coulomb friction, from event to event: stick, slip and drag.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/contact_material.h"
#include "core/force/contact_qp.h"
#include "core/force/sliding_friction.h"
#include "core/force/sphere/sphere_follower.h"
#include "core/math/find_zero.h"
#include "core/math/quadratic.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A pull within this share of the friction cone counts as on it: 4,096 times the rounding of a pull.
constexpr double kOnCone = 0x1p-40;
constexpr double kMinPull = OffsetDrag::kMinPull;
constexpr double kNearZero = 0x1p-51;  // rounding of a value that crosses zero

}  // namespace

FrictionCoefficients SphereFollower::coefficients(const OffsetContact& contact) const noexcept {
  const Material& material = near_.material(contact.triangle);
  return {material.friction_static, std::min(material.friction_dynamic, material.friction_static)};
}

bool SphereFollower::has_friction_here() const noexcept {
  const auto has_friction = [&](const OffsetContact& contact) { return coefficients(contact).static_mu > 0.0; };
  return has_friction_ && std::ranges::any_of(contacts_.all(), has_friction);
}

OffsetDrag SphereFollower::make_drag() noexcept {
  for (int i = 0; i < contacts_.active_count(); ++i) friction_.coefficients[i] = coefficients(contacts_[i]);
  return {contacts_.active(), std::span<const FrictionCoefficients>(friction_.coefficients).first(contacts_.active().size()),
          contacts_.offset()};
}

// The pull is within the cone, so the centre sticks. If it is on the cone, the device drags the centre as soon as the device moves.
SphereFollower::Next SphereFollower::hold(const OffsetDrag::Pull& pull) noexcept {
  const double cone = pull.friction.dynamic_mu * pull.depth;
  friction_.drags = friction_.slides && contacts_.active_count() < 3 && pull.length >= (1.0 - kOnCone) * cone - kMinPull;
  friction_.slides = friction_.slides && pull.length >= FrictionMotion::kRestick * cone;
  friction_.slips = false;
  is_descending_ = false;
  return Next::again;
}

// With the device held: moves the centre by one piece of path along the pull, at most to where the pull is on the cone.
SphereFollower::Next SphereFollower::descend_with_friction(const Vec3& device, const Vec3& motion) noexcept {
  Vec3 direction;
  if (!contacts_.find_active(centre_, device - centre_, motion, direction)) return Next::failed;
  if (contacts_.active_count() == 0) {
    contacts_.clear();
    friction_.slips = false;
    ++idle_events_;
    return Next::again;
  }
  const OffsetDrag drag = make_drag();
  OffsetDrag::Pull pull;
  if (!drag.find_pull(centre_, device, pull)) return Next::failed;
  const double cone = (friction_.slides ? pull.friction.dynamic_mu : pull.friction.static_mu) * (1.0 + kOnCone) * pull.depth;
  const bool moves = contacts_.active_count() < 3 && (friction_.slips || pull.length * pull.length > cone * cone + kMinPull * kMinPull);
  if (!moves) return hold(pull);
  const bool has_vanished = friction_.slips && friction_.has_vanished && !drag.is_flat();  // on flat parts no equilibrium vanishes
  friction_ = {.slides = true, .coefficients = friction_.coefficients};
  SlipPath slip;
  if (!drag_legs().make_slip(drag, pull, device, has_vanished, slip)) return Next::failed;
  if (slip.waits || slip.is_on_cone) {
    friction_.drags = true;
    is_descending_ = false;
    ++idle_events_;
    return slip.waits ? Next::wait : Next::again;
  }
  ++slips_;
  Event event;
  if (!events_on().find(slip.path, event)) return Next::failed;
  const bool is_whole = event.time >= 1.0;
  const Vec3 before = centre_;
  bool is_restored = true;
  events_on().place(slip.path, event, centre_, [&](double share) {
    OffsetDrag::Descent at{slip.is_exact ? slip.path.at(share) : before};
    is_restored = slip.is_exact || share <= 0.0 || drag.descend(device, slip.direction, share * slip.length, at, work_);
    centre_ = at.centre;
  });
  if (!is_restored) return Next::failed;
  note_move(before);
  note_gain(device, false);
  const bool ends = is_whole && event.contact < 0 && event.slot < 0;
  if (ends && slip.stops) {
    friction_.drags = true;
    is_descending_ = false;
  }
  if (!apply_event(event, slip.path)) return Next::failed;
  if (ends && slip.released >= 0) contacts_.remove(slip.released);
  return Next::again;
}

// With the device moving and the pull on the cone: moves the centre until the motion ends, or to the next event.
SphereFollower::Next SphereFollower::drag(const Vec3& from, const Vec3& to, double& time) noexcept {
  contacts_.keep_active();
  const OffsetDrag drag = make_drag();
  DragLeg leg;
  const DragOutcome outcome = drag_legs().make(drag, from, to, time, leg);
  if (outcome != DragOutcome::moves) {
    ++idle_events_;
    friction_.drags = false;
    friction_.slips = outcome == DragOutcome::jumps;
    friction_.has_vanished = friction_.slips;
    is_descending_ = friction_.slips;
    return Next::again;
  }
  Event event;
  if (!leg.is_clear && !events_on().find(leg.path, event)) return Next::failed;
  const Vec3 before = centre_;
  const Vec3 device = on_path(from, to, time);
  const double time_before = time;
  const bool is_whole = event.time >= 1.0;
  bool is_restored = true;
  events_on().place(leg.path, event, centre_, [&](double share) {
    time = share >= 1.0 ? leg.time : leg.is_exact ? leg.time_at(time_before, share) : time_before + share * (leg.time - time_before);
    centre_ = leg.path.at(share);
    if (share >= 1.0 || leg.is_exact) return;
    if (leg.is_line) time = time_on_line(drag, from, to, before, time_before, leg, share);
    OffsetDrag::Flow at{before, time_before};
    const bool flows = leg.flow > 0.0;
    if (flows ? drag.flow(from, to, share * leg.flow, at, work_) : drag.follow(device, on_path(from, to, time), at.centre, work_)) {
      centre_ = at.centre;
      if (flows) time = std::clamp(at.time, time_before, leg.time);
    } else {
      is_restored = contacts_.restore(centre_, work_);
    }
  });
  if (!is_restored) return Next::failed;
  note_move(before);
  const double device_travel = (time - time_before) * (to - from).norm();
  if (device_travel > least_progress()) note_gain(on_path(from, to, time), true);
  if (note_short_drag(device_travel)) return Next::failed;
  if (const auto next = end_leg(leg.path, event, is_whole, leg.released, on_path(from, to, time))) return *next;
  if (leg.stops) friction_.drags = false;
  if (leg.jumps) {
    friction_.slips = true;
    friction_.has_vanished = true;
    is_descending_ = true;
    return Next::again;
  }
  return time >= 1.0 ? Next::settled : Next::again;
}

// A pull that is and stays much shorter than the motion, as along an edge that the device only just passes, is followed in pieces of a few
// times the length of the pull. True: there were so many short pieces that sweeps must continue the motion.
bool SphereFollower::note_short_drag(double device_travel) noexcept {
  constexpr double kShort = 0x1p-24;  // local units: a shorter motion of the device counts as short
  constexpr int kMany = 256;          // drags; a free choice
  short_drags_ = device_travel < kShort ? short_drags_ + 1 : 0;
  return short_drags_ > kMany;
}

// The time at which the device has dragged the centre along the given share of a line.
double SphereFollower::time_on_line(const OffsetDrag& drag, const Vec3& from, const Vec3& to, const Vec3& start, double time,
                                    const DragLeg& leg, double share) noexcept {
  const Vec3 line = leg.path.at(1.0) - start;
  const double length = line.norm();
  if (!(length > 0.0)) return time;
  const Vec3 device = on_path(from, to, time);
  const auto left_at = [&](double t) {
    Vec3 c = start;
    return drag.follow(device, on_path(from, to, t), c, work_) ? share * length - line.dot(c - start) / length
                                                               : std::numeric_limits<double>::quiet_NaN();
  };
  return find_zero(time, share * length, leg.time, -(1.0 - share) * length, kNearZero, left_at);
}

// The reaction of all contacts to the pull on a centre that stays where it is.
SphereFollower::Reaction SphereFollower::find_reaction(const Vec3& pull) const noexcept {
  Reaction reaction;
  std::array<ContactPlane, ContactSet::kMax> planes;
  for (int i = 0; i < contacts_.count(); ++i) planes[i] = {contacts_[i].proximity(centre_).normal, 0.0};
  const ConstrainedMotion constrained = constrain_motion(pull, std::span(planes).first(contacts_.count()));
  if (!constrained.solved) return reaction;
  ContactMaterial material;
  for (int i = 0; i < constrained.active_count; ++i) {
    material.add(near_.material(contacts_[constrained.active[i]].triangle), constrained.multipliers[i]);
  }
  reaction.is_free = constrained.active_count == 0;
  reaction.friction = {material.mean().friction_static, std::min(material.mean().friction_static, material.mean().friction_dynamic)};
  reaction.tangential = constrained.active_count == 3 ? 0.0 : constrained.motion.norm();
  reaction.depth = (pull - constrained.motion).norm();
  reaction.is_known = true;
  return reaction;
}

// Finds the time at which the pull on a sticking centre leaves the friction cone of its active contacts, and that at which it is well
// within the cone again. Each contact and each pair gives a quadratic equation for it; a root counts if those contacts are active then.
class SphereFollower::StickSearch {
 public:
  // start: the pull now; motion: that of the device until the end; end: the pull at the end.
  StickSearch(SphereFollower& follower, const Vec3& start, const Vec3& motion, const Vec3& end) noexcept
      : follower_(follower), start_(start), motion_(motion), end_(end), slides_(follower.friction_.slides) {}

  void run() noexcept {
    if (excess_at(0.0) > 4.0 * kOnCone * start_.norm() + 2.0 * kMinPull) slip_time_ = 0.0;
    const ContactSet& contacts = follower_.contacts_;
    for (int i = 0; i < contacts.count(); ++i) {
      ++follower_.work_;
      const Vec3 normal = contacts[i].proximity(follower_.centre_).normal;
      const FrictionCoefficients friction = follower_.coefficients(contacts[i]);
      consider_contact(normal, friction);
      for (int j = i + 1; j < contacts.count(); ++j) consider_pair(normal, friction, contacts[j]);
    }
    if (!(slip_time_ <= 1.0)) find_numerically();
  }

  // Times from the start, 0 to 1; infinite: not before the end.
  double slip_time() const noexcept { return slip_time_; }
  double restick_time() const noexcept { return restick_time_; }

 private:
  Vec3 pull_at(double t) const noexcept { return start_ + t * motion_; }
  double mu_of(const FrictionCoefficients& friction) const noexcept { return slides_ ? friction.dynamic_mu : friction.static_mu; }

  // The excess of the pull over the cone: positive outside of the cone.
  double excess_at(double t) const noexcept {
    const Vec3 pull = t < 1.0 ? pull_at(t) : end_;
    const Reaction reaction = follower_.find_reaction(pull);
    if (!reaction.is_known) return -1.0;
    if (reaction.is_free) return pull.norm();
    return reaction.tangential - mu_of(reaction.friction) * reaction.depth;
  }

  double restick_margin(double t) const noexcept {
    const Reaction reaction = follower_.find_reaction(pull_at(t));
    return reaction.is_known && !reaction.is_free
               ? FrictionMotion::kRestick * reaction.friction.dynamic_mu * reaction.depth - reaction.tangential
               : -1.0;
  }

  void consider_slip(double t) noexcept {
    if (!(t < slip_time_) || !(t <= 1.0)) return;
    if (excess_at(t) >= -(4.0 * kOnCone * pull_at(t).norm() + 2.0 * kMinPull)) slip_time_ = t;
  }

  void consider_restick(double t) noexcept {
    if (!(t < restick_time_) || !(t < 1.0)) return;
    if (restick_margin(t) >= -(4.0 * kOnCone * pull_at(t).norm())) restick_time_ = t;
  }

  // The time at which of_square |pull|^2 + of_part (direction . pull)^2 - bound rises to zero; infinite: it does not.
  double rise(double of_square, const Vec3& direction, double of_part, double bound) const noexcept {
    const double rate = direction.dot(motion_);
    const double height = direction.dot(start_);
    const double now = of_square * start_squared_ + of_part * height * height - bound;
    // Clearly above zero at the start: so this is not the cone of the contacts that are active now.
    const bool is_above = now > 8.0 * kOnCone * start_squared_ + 4.0 * kMinPull * start_.norm();
    const double t = time_of_rise(of_square * motion_squared_ + of_part * rate * rate,
                                  of_square * start_dot_motion_ + of_part * rate * height, now, 2.0 * kOnCone * start_squared_);
    return is_above && t == 0.0 ? kInfinity : t;
  }

  // Considers the cone of one contact, and the end of that contact.
  void consider_contact(const Vec3& normal, const FrictionCoefficients& friction) noexcept {
    const double mu = mu_of(friction);
    consider_slip(rise(1.0, normal, -(1.0 + mu * mu), kMinPull * kMinPull));
    if (slides_) {
      const double least = FrictionMotion::kRestick * friction.dynamic_mu;
      consider_restick(rise(-1.0, normal, 1.0 + least * least, 0.0));
    }
    const double height = normal.dot(start_);
    const double there = normal.dot(start_ + motion_);
    if (height < 0.0 && there > 0.0) consider_slip(height / (height - there));
  }

  // Considers the cone of two contacts, about the line along which they leave the centre free.
  void consider_pair(const Vec3& normal, const FrictionCoefficients& friction, const OffsetContact& other) noexcept {
    const Vec3 line = accurate_cross(normal, other.proximity(follower_.centre_).normal);
    if (!(line.norm() > 0x1p-40)) return;
    const Vec3 along = line.normalized();
    for (const FrictionCoefficients& each : {friction, follower_.coefficients(other)}) {
      const double mu = mu_of(each);
      consider_slip(rise(-mu * mu, along, 1.0 + mu * mu, kMinPull * kMinPull));
      if (slides_) {
        const double least = FrictionMotion::kRestick * each.dynamic_mu;
        consider_restick(rise(least * least, along, -(1.0 + least * least), 0.0));
      }
    }
  }

  // With different materials, the cone of a pair is not one of those considered before: searches for the time at which the pull leaves it.
  void find_numerically() noexcept {
    const double end = excess_at(1.0);
    const double tolerance = 4.0 * kOnCone * (start_.norm() + motion_.norm()) + 2.0 * kMinPull;
    if (!(end > tolerance)) return;
    slip_time_ = find_zero(0.0, std::max(0.0, -excess_at(0.0)), 1.0, -end, kNearZero, [&](double t) { return -excess_at(t); });
  }

  SphereFollower& follower_;
  const Vec3& start_;
  const Vec3& motion_;
  const Vec3& end_;
  const double start_squared_ = start_.squaredNorm();
  const double start_dot_motion_ = start_.dot(motion_);
  const double motion_squared_ = motion_.squaredNorm();
  const bool slides_;
  double slip_time_ = kInfinity;
  double restick_time_ = kInfinity;
};

// The centre sticks until the pull leaves the cone of the active contacts. Flattened, so that the search stays in registers.
[[gnu::flatten]] SphereFollower::Next SphereFollower::stay_with_friction(const Vec3& from, const Vec3& to, double& time) noexcept {
  const Vec3 start = on_path(from, to, time) - centre_;
  const Vec3 motion = (1.0 - time) * (to - from);
  const Vec3 end = to - centre_;
  StickSearch search(*this, start, motion, end);
  search.run();
  const double slip_time = search.slip_time();
  const double restick_time = search.restick_time();
  const double first = std::min({slip_time, restick_time, 1.0});
  ++idle_events_;
  if (first * motion.norm() > LocalMinimum::kMinMotion) idle_events_ = 0;
  least_distance_ = kInfinity;
  time = first >= 1.0 ? 1.0 : time + first * (1.0 - time);
  if (slip_time <= 1.0 && slip_time <= restick_time) {
    friction_.slips = true;
    friction_.has_vanished = false;
    is_descending_ = true;
    return Next::again;
  }
  if (restick_time < 1.0) {
    friction_.slides = false;
    return Next::again;
  }
  Vec3 direction;
  return contacts_.find_active(centre_, end, to - from, direction) ? Next::settled : Next::failed;
}

}  // namespace hapton
