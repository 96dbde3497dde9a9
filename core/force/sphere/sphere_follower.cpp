#include "core/force/sphere/sphere_follower.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/collision/swept_sphere.h"
#include "core/force/contact_qp.h"
#include "core/force/sphere/descent_path.h"
#include "core/force/sphere/minimum_legs.h"
#include "core/math/straight_motion.h"

namespace hapton {

bool SphereFollower::start(const Vec3& centre, bool is_free, double short_by, bool slides) noexcept {
  work_ = 0;
  is_tracking_ = false;
  is_in_slit_ = false;
  friction_ = {.slides = slides, .coefficients = {}};
  centre_ = centre;
  contacts_.clear();
  is_descending_ = true;
  is_carried_ = false;
  has_lost_minimum_ = false;
  direction_hint_ = Vec3::Zero();
  if (!near_.reach(centre_, clearance().offset + 2.0 * clearance().tolerance, work_)) return false;
  if (!near_.is_clear(centre_, short_by + clearance().slop, work_)) return false;
  is_tracking_ = true;
  if (is_free) return true;
  // Lifts the centre until it is at the offset from all triangles that it touches.
  constexpr int kMaxLifts = 3;
  for (int i = 0; i < kMaxLifts; ++i) {
    std::array<ContactPlane, ContactSet::kMax> planes;
    contacts_.clear();
    near_.visit_near(centre_, centre_, clearance().offset + clearance().tolerance, [&](int slot) {
      ++work_;
      const ContactTriangle& shape = near_.shape(slot);
      const Separation at = shape.separation(centre_);
      const double gap = at.distance - clearance().offset;
      if (gap > clearance().tolerance || contacts_.count() == ContactSet::kMax || !near_.can_touch(near_.triangle(slot), shape, centre_))
        return;
      const bool is_known = std::ranges::any_of(contacts_.all(), [&](const OffsetContact& other) { return other.is_shared_with(shape); });
      if (is_known && gap > -clearance().slop) return;
      planes[contacts_.count()] = {at.normal, -gap};
      contacts_.add(OffsetContact::nearest(near_.triangle(slot), shape, centre_));
    });
    const ConstrainedMotion lift = constrain_motion(Vec3::Zero(), std::span(planes).first(contacts_.count()));
    if (!lift.solved || lift.motion.norm() > 64.0 * short_by) return is_tracking_ = false;
    if (lift.motion.norm() <= clearance().tolerance) break;
    centre_ += lift.motion;
  }
  return is_tracking_ = near_.is_clear(centre_, clearance().slop, work_);
}

void SphereFollower::forget() noexcept {
  stop_tracking();
  forget_near();
  near_.reset();
  direction_hint_ = Vec3::Zero();
  lingered_at_ = Vec3::Zero();
  slit_at_.reset();
  lingering_events_ = 0;
  idle_events_ = 0;
  has_lost_minimum_ = false;
  corner_.has_cone = false;
  has_untried_escapes_ = false;
  untried_escapes_at_.reset();
  failed_escapes_ = 0;
  motion_ = 1;
  last_fly_over_ = 0;
}

void SphereFollower::start_free(const Vec3& centre) noexcept {
  centre_ = centre;
  contacts_.clear();
  friction_ = {};
  is_carried_ = false;
  is_tracking_ = true;
}

// The interval of time in which the straight motion is inside a ball around the scene. Empty: end < begin.
SphereFollower::Span SphereFollower::find_span(const Vec3& from, const Vec3& to) {
  const Vec3 motion = to - from;
  const double length = motion.norm();
  if (!(from.squaredNorm() > kFarDistance * kFarDistance) && !(to.squaredNorm() > kFarDistance * kFarDistance)) return {0.0, 1.0};
  const Vec3 direction = length > 0.0 ? Vec3(motion / length) : Vec3::Zero();
  const double closest = -from.dot(direction);
  const double miss = (from + closest * direction).norm();
  if (!(miss < kFarDistance) || !(length > 0.0)) return {1.0, 0.0};
  const double half = std::sqrt((kFarDistance - miss) * (kFarDistance + miss));
  return {std::max(0.0, (closest - half) / length), std::min(1.0, (closest + half) / length)};
}

// Failed attempts are counted over all steps of a motion that is carried on from step to step (is_carried_).
SphereFollower::Outcome SphereFollower::follow(const Vec3& from, const Vec3& to, double& time, int most_work) noexcept {
  work_ = 0;
  most_work_ = most_work;
  has_given_up_flight_ = false;
  is_in_slit_ = false;
  if (!is_carried_) {
    idle_events_ = 0;
    ++motion_;
    corner_tries_ = 0;
    skip_count_ = 0;
    short_drags_ = 0;
    lingered_at_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  }
  if (!has_untried_escapes_) {
    failed_escapes_ = 0;
    untried_escapes_at_.reset();
  }
  has_untried_escapes_ = false;
  const Outcome outcome = from.allFinite() && to.allFinite() ? follow_finite(from, to, time) : Outcome::failed;
  is_carried_ = outcome == Outcome::exhausted;
  const bool is_far = from.squaredNorm() > kFarDistance * kFarDistance || to.squaredNorm() > kFarDistance * kFarDistance;
  is_in_slit_ &= time >= 1.0 && !is_far;
  if (is_carried_ && is_far) {  // positions so far out are too coarse to continue from
    time = 1.0;
    is_descending_ = !contacts_.is_empty();
  }
  return outcome;
}

// While the device is farther out than positions are resolved (kFarDistance), only its direction from the centre counts.
SphereFollower::Outcome SphereFollower::follow_finite(const Vec3& from, const Vec3& to, double& time) noexcept {
  const Span span = find_span(from, to);
  Outcome outcome = Outcome::settled;
  bool is_with_device = contacts_.is_empty() && centre_ == on_path(from, to, time);
  if (span.begin <= span.end && time <= span.end) {
    const Vec3 first = on_path(from, to, span.begin);
    const Vec3 last = on_path(from, to, span.end);
    const double length = span.end - span.begin;
    double part = length > 0.0 ? std::max(0.0, (time - span.begin) / length) : 0.0;
    if (span.begin > time) {
      if (is_with_device) centre_ = first;
      is_descending_ = !contacts_.is_empty();
    }
    outcome = follow_near(first, last, part);
    time = span.end >= 1.0 && part >= 1.0 ? 1.0 : span.begin + part * length;
    if (outcome != Outcome::settled || span.end >= 1.0) return outcome;
    is_with_device = contacts_.is_empty();
  }
  if (is_with_device) {  // there are no triangles so far out
    centre_ = to;
    time = 1.0;
    return Outcome::settled;
  }
  // Whether a centre is at a minimum depends only on the direction to the device, which turns as the centre moves. Each turn is about the
  // same share of the turn before, so every third turn goes to where the sum of all later ones would lead.
  std::array<double, 3> turn_lengths{};
  Vec3 ahead = Vec3::Zero();
  for (int i = 0; i < kMaxTurns; ++i) {
    const Vec3 before = centre_;
    const Vec3 target = centre_ + (to - centre_) * (kFarDistance / (to - centre_).norm()) + ahead;
    is_descending_ = true;
    if (target != far_target_) least_distance_ = std::numeric_limits<double>::infinity();  // a distance to another target says nothing
    far_target_ = target;
    double part = 0.0;
    outcome = follow_near(target, target, part);
    if (outcome != Outcome::settled) return outcome;
    const Vec3 turn = centre_ - before;
    turn_lengths[i % 3] = turn.norm();
    if (contacts_.is_empty() || (i % 3 != 2 && turn.norm() <= LocalMinimum::kAtMinimum)) break;
    if (work_ > most_work_) return Outcome::exhausted;
    const double share = i % 3 == 1 && turn_lengths[1] < turn_lengths[0] ? turn_lengths[1] / turn_lengths[0] : 0.0;
    ahead = turn * std::min(share / (1.0 - share), 1.0 / turn.norm());
  }
  time = 1.0;
  if (contacts_.is_empty()) centre_ = to;
  return outcome;
}

// A point that has moved by less than its offset in many events continues by a sweep: within rounding, the contacts that hold it change
// from one event to the next. In a slit, where a sweep would push it out, the device first moves on to the end of its motion.
SphereFollower::Outcome SphereFollower::follow_near(const Vec3& from, const Vec3& to, double& time) noexcept {
  constexpr std::uint64_t kManyEvents = 24;  // of the 30 to 60 events for which the work of a step is enough; a free choice
  if (!is_carried_) least_distance_ = std::numeric_limits<double>::infinity();
  const Vec3 start = centre_;
  const bool slid_at_start = friction_.slides;
  const double start_time = time;
  const std::uint64_t events_before = events_;
  const bool has_fans = !is_point_ && fan_.exists();
  Next next = Next::again;
  while (next == Next::again && work_ <= most_work_) {
    ++events_;
    work_ += kWorkOfEvent;
    if (idle_events_ > kMaxIdleEvents && !(is_point_ && skip_ahead(from, to, time))) break;
    next = follow_event(from, to, time, has_fans);
    if (next == Next::wait) next = wait(from, to, time);
    if (next == Next::again && note_lingering())
      time = std::min(1.0, time + std::ldexp(4.0 * LocalMinimum::kAtAxis, lingering_events_ / 4) / (to - from).norm());
    if (next == Next::settled && !has_friction_here() && leave_minimum(to, to - from)) next = Next::again;
  }
  queried_ += static_cast<std::uint64_t>(work_);
  const bool has_stuck = has_friction_ && centre_ == start;
  const bool is_astray = next == Next::failed && !contacts_.touches_all(centre_);
  if (!contacts_.is_empty() && !has_stuck && (is_astray || !near_.is_clear_here(centre_, 2.0 * clearance().slop, work_))) {
    centre_ = start;
    contacts_.clear();
    friction_ = {.slides = slid_at_start, .coefficients = {}};  // a sweep continues from the start with this state
    time = start_time;
    return Outcome::failed;
  }
  if (next == Next::failed || idle_events_ > kMaxIdleEvents) return Outcome::failed;
  contacts_.note_multipliers(centre_, to);
  if (has_untried_escapes_) return Outcome::exhausted;
  if (next == Next::settled) {
    Vec3 direction;
    const bool has_friction = has_friction_here();
    is_in_slit_ = is_point_ && !has_friction && fills_slit() && note_slit(from != to);
    const bool is_shallow = !is_point_ && !has_friction && minimum().is_shallow(centre_, to, direction);
    return is_in_slit_ || is_shallow ? Outcome::failed : Outcome::settled;
  }
  const double progress = std::max((centre_ - start).norm(), (time - start_time) * (to - from).norm());
  const bool has_crept = events_ - events_before > kManyEvents && progress < clearance().offset && is_point_ && !has_friction_;
  if (!has_crept) return Outcome::exhausted;
  if (!is_in_narrow_slit()) return Outcome::failed;
  if (time < 1.0) {
    time = 1.0;
    is_descending_ = true;
    return Outcome::exhausted;
  }
  is_in_slit_ = note_slit(from != to);
  return is_in_slit_ ? Outcome::failed : Outcome::settled;
}

// Finds and applies the next event of a centre that is free, or held with or without friction. has_fans: it may cross large fans.
SphereFollower::Next SphereFollower::follow_event(const Vec3& from, const Vec3& to, double& time, bool has_fans) noexcept {
  if (contacts_.is_empty()) return fly(from, to, time);
  if (has_friction_here()) {
    if (is_descending_) return descend_with_friction(on_path(from, to, time), to - from);
    return friction_.drags ? drag(from, to, time) : stay_with_friction(from, to, time);
  }
  if (has_fans && cross_fan(from, to, time) && !is_descending_ && time >= 1.0) return Next::settled;
  return is_descending_ ? descend(on_path(from, to, time), to - from) : slide(from, to, time);
}

// Whether many events had one place and hardly any motion of the device: within rounding, what holds the centre changes each time.
bool SphereFollower::note_lingering() noexcept {
  constexpr int kMany = 64;  // events; a free choice
  if (is_descending_ && (centre_ - lingered_at_).norm() <= LocalMinimum::kMinMotion) return ++lingering_events_ > 0;
  if ((centre_ - lingered_at_).norm() > LocalMinimum::kMinMotion) {
    lingered_at_ = centre_;
    lingering_events_ = -kMany;
  }
  return false;
}

// Called after events without progress: within rounding, it is open whether the centre is at a minimum. Moves the device on a little, so
// that this is decided or the device has arrived. False: it cannot.
bool SphereFollower::skip_ahead(const Vec3& from, const Vec3& to, double& time) noexcept {
  const double length = (to - from).norm();
  if (time >= 1.0 || !(length > 0.0) || skip_count_ > kMaxSkips) return false;
  time = std::min(1.0, time + std::ldexp(4.0 * LocalMinimum::kAtAxis, skip_count_) / length);
  ++skip_count_;
  idle_events_ = 0;
  is_descending_ = !contacts_.is_empty();
  return true;
}

// After a displacement, contacts that were not active are dropped; they are hit again if they are in the way.
bool SphereFollower::note_move(const Vec3& from) noexcept {
  ++idle_events_;
  const bool has_moved = (centre_ - from).norm() > LocalMinimum::kMinMotion;
  if (has_moved) contacts_.keep_active();
  return has_moved;
}

// Resets idle_events_ on progress: the device has moved, or the centre is nearer to it than at any time since the device last moved.
void SphereFollower::note_gain(const Vec3& device, bool has_moved) noexcept {
  const double distance = (device - centre_).norm();
  if (has_moved || distance < least_distance_ - kMinGain) idle_events_ = 0;
  if (has_moved || distance < least_distance_) least_distance_ = distance;
}

// The path keeps an offset from all triangles. A centre farther off the path than a part of that may be on the other side of a face.
bool SphereFollower::is_near_path(const Vec3& centre, const CentrePath& path, double share) const noexcept {
  constexpr double kNear = 0.25;  // share of the offset
  return (centre - path.at(share)).norm() <= kNear * clearance().offset;
}

// With the device held: moves the centre by one piece of the steepest descent, at most to a minimum.
SphereFollower::Next SphereFollower::descend(const Vec3& device, const Vec3& motion) noexcept {
  if (is_point_ && contacts_.count() > 1) {
    contacts_.activate_all();  // also those of the last event, which find_active() has not seen
    if (straighten_in_slit()) return Next::again;
  }
  const Vec3 pull = device - centre_;
  Vec3 descent;
  if (!contacts_.find_active(centre_, pull, motion, descent)) return is_point_ && is_in_narrow_slit() ? Next::wait : Next::failed;
  if (contacts_.active_count() == 0) {
    contacts_.clear();
    ++idle_events_;
    return Next::again;
  }

  const bool is_at_rest = contacts_.active_count() == 3 || descent.norm() <= LocalMinimum::kAtMinimum;
  const bool is_unstable = is_at_rest && contacts_.active_count() < 3 && !minimum().is_on_axis(device) &&
                           (has_lost_minimum_ || minimum().find_stability(centre_, device) <= 0.0);
  if (is_at_rest && !is_unstable) {
    activate_opposing(contacts_, centre_, device, motion);
  } else {
    has_lost_minimum_ = false;
  }
  if (is_at_rest && (!is_unstable || !find_escape_direction(motion))) {
    is_descending_ = false;
    contacts_.keep_active();
    return Next::again;
  }
  CentrePath path;
  const DescentPath descent_path(contacts_, centre_, work_);
  const bool returns = !is_unstable && descent_path.return_to_crease(path);
  const bool has_path = returns || descent_path.make(device, direction_hint_, is_unstable, path);
  return has_path && !opens_within_rounding(path, device - centre_) ? descend_along(path, device, !returns)
                                                                    : descend_no_farther(device, is_unstable);
}

// Along an edge in a slit, the curve of both contacts may end within the rounding of positions. True: the slit opens there, because within
// the rounding of its normal the edge does not stop a centre that moves over the other contact alone.
bool SphereFollower::opens_within_rounding(const CentrePath& path, const Vec3& pull) const noexcept {
  constexpr double kRounding = 0x1p-51;  // local units: the error of a position; divided by the offset, that of a normal
  if (!is_point_ || contacts_.active_count() != 2 || (path.end() - path.start()).norm() > LocalMinimum::kMinMotion) return false;
  const std::array<Vec3, 2> normal{contacts_[0].proximity(centre_).normal, contacts_[1].proximity(centre_).normal};
  const std::size_t weaker = normal[0].dot(pull) < normal[1].dot(pull) ? 1 : 0;
  const Vec3& other = normal[1 - weaker];
  const Vec3 over_other = pull - other.dot(pull) * other;
  return contacts_[static_cast<int>(weaker)].is_curved() && is_in_narrow_slit() &&
         clearance().offset * normal[weaker].dot(over_other) > -kRounding * over_other.norm();
}

// Called where no piece of a descent is found.
SphereFollower::Next SphereFollower::descend_no_farther(const Vec3& device, bool is_unstable) noexcept {
  const bool may_drop = contacts_.active_count() == 2 && is_point_;
  if (!is_unstable) return drop_weaker(device - centre_);
  // The minimum has vanished, and neither way along the curve leads nearer: the two contacts are one within rounding.
  if (may_drop && (are_same_contact() || minimum().find_stability(centre_, device) <= 0.0)) return drop_weaker(device - centre_);
  is_descending_ = false;
  contacts_.keep_active();
  ++idle_events_;
  return Next::wait;
}

// Moves the centre to the first event on the path. `is_on_contacts`: the exact path stays at the offset from the active contacts.
SphereFollower::Next SphereFollower::descend_along(const CentrePath& path, const Vec3& device, bool is_on_contacts) noexcept {
  Event event;
  if (!events_on().find(path, event)) return Next::failed;
  const Vec3 before = centre_;
  bool is_restored = true;
  events_on().place(path, event, centre_, [&](double share) {
    centre_ = path.at(share);
    is_restored = !is_on_contacts || (contacts_.restore(centre_, work_) && is_near_path(centre_, path, share));
  });
  if (!is_restored) {
    centre_ = before;
    events_on().undo_level_faces();
    return drop_weaker(device - centre_);
  }
  note_move(before);
  note_gain(device, false);
  // Over a single face the path ends at the minimum.
  const bool is_at_rest =
      event.time >= 1.0 && event.contact < 0 && event.slot < 0 && contacts_.count() == 1 && contacts_[0].part == Feature::face;
  if (is_at_rest) is_descending_ = false;
  return apply_event(event, path) ? Next::again : Next::failed;
}

// Follows the device over the faces of a large fan. False: no fan here can be crossed, or this moves the centre no farther.
bool SphereFollower::cross_fan(const Vec3& from, const Vec3& to, double& time) noexcept {
  const Vec3 start = centre_;
  const double start_time = time;
  const LargeFan::Crossing crossing = fan_.cross({contacts_, near_, centre_, is_descending_, work_, most_work_}, from, to, time);
  if (crossing == LargeFan::Crossing::none) return false;
  direction_hint_ = centre_ - start;
  if (crossing == LargeFan::Crossing::hollow) {
    has_lost_minimum_ = false;
    note_gain(on_path(from, to, time), time > start_time || direction_hint_.norm() > LocalMinimum::kMinMotion);
  } else {
    note_gain(on_path(from, to, time), time > start_time);
    idle_events_ = 0;
  }
  return true;
}

// Whether two contacts count as one: either of them alone keeps the centre at the offset from both, within the tolerance.
bool SphereFollower::are_same_contact() const noexcept {
  const double cosine = contacts_[0].proximity(centre_).normal.dot(contacts_[1].proximity(centre_).normal);
  return clearance().offset * (1.0 - cosine) <= clearance().tolerance;
}

// Two contacts of a point whose normals are nearly parallel: drops the one that holds less. It is hit again if it is in the way.
SphereFollower::Next SphereFollower::drop_weaker(const Vec3& pull) noexcept {
  if (contacts_.active_count() != 2 || !is_point_) return Next::failed;
  const double first = contacts_[0].proximity(centre_).normal.dot(pull);
  const double second = contacts_[1].proximity(centre_).normal.dot(pull);
  contacts_.remove(first < second ? 1 : 0);
  contacts_.keep_active();
  ++idle_events_;
  return Next::again;
}

// With the device moving: moves the centre until the device has arrived, or to the next event.
SphereFollower::Next SphereFollower::slide(const Vec3& from, const Vec3& to, double& time) noexcept {
  contacts_.activate_all();
  if (contacts_.active_count() == 3) return stay(from, to, time);
  MinimumLeg leg;
  if (!MinimumLegs(contacts_, centre_, work_).make(from, to, time, leg)) {
    const Vec3 rate = minimum().find_rate(centre_, on_path(from, to, time), to - from);
    return lose_minimum(rate.allFinite() && !rate.isZero(0.0) ? rate : Vec3(to - from));
  }
  Event event;
  if (!events_on().find(leg.path, event)) return Next::failed;
  const Vec3 before = centre_;
  const double time_before = time;
  const bool is_whole = event.time >= 1.0;
  bool is_restored = true;
  events_on().place(leg.path, event, centre_, [&](double share) {
    time = share >= 1.0 ? leg.time : time_before + share * (leg.time - time_before);
    centre_ = leg.path.at(share);
    if (leg.is_on_curve) {
      is_restored = contacts_.restore(centre_, work_) && is_near_path(centre_, leg.path, share);
      if (share < 1.0) time = std::clamp(MinimumLegs(contacts_, centre_, work_).time_on_curve(from, to), time_before, leg.time);
      return;
    }
    if (leg.path.is_straight() || (minimum().solve(on_path(from, to, time), centre_, work_) && is_near_path(centre_, leg.path, share)))
      return;
    centre_ = leg.path.at(share);
    is_restored = contacts_.restore(centre_, work_);
  });
  if (!is_restored) return Next::failed;
  const bool has_moved = note_move(before);
  if ((time - time_before) * (to - from).norm() > least_progress()) note_gain(on_path(from, to, time), true);
  if (const auto next = end_leg(leg.path, event, is_whole, leg.released, on_path(from, to, time))) return *next;
  if (leg.vanishes) return lose_minimum(leg.path.slope(1.0));
  if (!has_moved && roll_off_face()) return Next::again;
  return time >= 1.0 ? Next::settled : Next::again;
}

// Applies the event at the end of a leg, or releases the contact whose multiplier is zero there. None: there was neither, and the leg was
// followed to its end.
std::optional<SphereFollower::Next> SphereFollower::end_leg(const CentrePath& path, const Event& event, bool is_whole, int released,
                                                            const Vec3& device) noexcept {
  if (!apply_event(event, path)) return Next::failed;
  if (event.contact >= 0 || event.slot >= 0 || !is_whole) return Next::again;
  if (released < 0) return std::nullopt;
  ++idle_events_;
  direction_hint_ =
      contacts_[released].proximity(centre_).normal;  // if the others alone do not hold the centre, it moves away from this contact
  contacts_.remove(released);
  is_descending_ = !contacts_.is_empty();
  if (is_descending_) return Next::again;
  centre_ = device;
  friction_ = {};  // the centre is free, at the device: it sticks where it lands, even within this motion
  return Next::again;
}

}  // namespace hapton
