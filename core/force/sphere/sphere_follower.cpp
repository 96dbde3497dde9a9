#include "core/force/sphere/sphere_follower.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/collision/swept_sphere.h"
#include "core/force/contact_qp.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

using Part = OffsetContact::Part;

}  // namespace

bool SphereFollower::can_touch(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& p) const noexcept {
  return materials_[geometry_.mesh_of(triangle)].two_sided || shape.normal().dot(p - shape.corner(0)) > 0.0;
}

// No triangle near is nearer than it may be. Those that only others cannot tell from a hit are let pass by `short_by`.
bool SphereFollower::is_clear(double short_by) noexcept {
  bool clear = true;
  near_.visit_near(centre_, centre_, keep_.offset - short_by, [&](int slot) {
    if (!clear) return;
    ++work_;
    const ContactTriangle& shape = near_.shape(slot);
    clear = shape.separation(centre_).distance >= keep_.offset - short_by || !can_touch(near_.triangle(slot), shape, centre_);
  });
  return clear;
}

// What cannot go on may have left the triangles gathered.
bool SphereFollower::is_clear_here(double short_by) noexcept {
  return (near_.covers(centre_, keep_.offset) || gather(Vec3::Zero())) && is_clear(short_by);
}

bool SphereFollower::take(const Vec3& centre, bool is_free, double short_by, bool slides) noexcept {
  holds_ = false;
  rub_ = {.slides = slides, .coefficients = {}};
  centre_ = centre;
  count_ = 0;
  touching_ = 0;
  is_descending_ = true;
  has_lost_minimum_ = false;
  hint_ = Vec3::Zero();
  if (!near_.covers(centre_, keep_.offset + 2.0 * keep_.tolerance) && !gather(Vec3::Zero())) return false;
  if (!is_clear(short_by + keep_.slop)) return false;
  holds_ = true;
  if (is_free) return true;
  // Lifted to the offset over all that it touches.
  constexpr int kMostLifts = 3;
  for (int i = 0; i < kMostLifts; ++i) {
    std::array<ContactPlane, kMostContacts> planes;
    touching_ = 0;
    near_.visit_near(centre_, centre_, keep_.offset + keep_.tolerance, [&](int slot) {
      const ContactTriangle& shape = near_.shape(slot);
      const Separation at = shape.separation(centre_);
      const double gap = at.distance - keep_.offset;
      if (gap > keep_.tolerance || touching_ == kMostContacts || !can_touch(near_.triangle(slot), shape, centre_)) return;
      const bool is_known = std::any_of(contacts_.begin(), contacts_.begin() + touching_,
                                        [&](const OffsetContact& other) { return other.is_part_of(shape); });
      if (is_known && gap > -keep_.slop) return;
      planes[touching_] = {at.normal, -gap};
      contacts_[touching_++] = OffsetContact::nearest(near_.triangle(slot), shape, centre_);
    });
    const ConstrainedMotion lift =
        constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes.data(), static_cast<std::size_t>(touching_)));
    if (!lift.solved || lift.motion.norm() > 64.0 * short_by) return holds_ = false;
    if (lift.motion.norm() <= keep_.tolerance) break;
    centre_ += lift.motion;
  }
  return holds_ = is_clear(keep_.slop);
}

void SphereFollower::take_free(const Vec3& centre) noexcept {
  centre_ = centre;
  count_ = 0;
  touching_ = 0;
  rub_ = {};
  holds_ = true;
}

// Where the straight way is within a ball round the scene, in time. Empty: end < begin.
SphereFollower::Span SphereFollower::find_span(const Vec3& from, const Vec3& to) {
  const Vec3 way = to - from;
  const double length = way.norm();
  if (!(from.squaredNorm() > kFar * kFar) && !(to.squaredNorm() > kFar * kFar)) return {0.0, 1.0};
  const Vec3 direction = length > 0.0 ? Vec3(way / length) : Vec3::Zero();
  const double foot = -from.dot(direction);
  const double miss = (from + foot * direction).norm();
  if (!(miss < kFar) || !(length > 0.0)) return {1.0, 0.0};
  const double half = std::sqrt((kFar - miss) * (kFar + miss));
  return {std::max(0.0, (foot - half) / length), std::min(1.0, (foot + half) / length)};
}

// While the device is farther out than the digits reach, only where it is counts, as seen from the centre.
SphereFollower::Outcome SphereFollower::follow(const Vec3& from, const Vec3& to, double& time) noexcept {
  work_ = 0;
  idle_ = 0;
  ++step_;
  exit_work_ = 0;
  corner_tries_ = 0;
  passes_ = 0;
  if (!from.allFinite() || !to.allFinite()) return Outcome::unclear;
  const Span span = find_span(from, to);
  Outcome outcome = Outcome::settled;
  bool is_with_device = touching_ == 0 && centre_ == on_path(from, to, time);
  if (span.begin <= span.end && time <= span.end) {
    const Vec3 first = on_path(from, to, span.begin);
    const Vec3 last = on_path(from, to, span.end);
    const double length = span.end - span.begin;
    double part = length > 0.0 ? std::max(0.0, (time - span.begin) / length) : 0.0;
    if (span.begin > time) {
      if (is_with_device) centre_ = first;
      is_descending_ = touching_ != 0;
    }
    outcome = follow_near(first, last, part);
    time = span.end >= 1.0 && part >= 1.0 ? 1.0 : span.begin + part * length;
    if (outcome != Outcome::settled || span.end >= 1.0) return outcome;
    is_with_device = touching_ == 0;
  }
  if (is_with_device) {  // there is nothing to meet out there
    centre_ = to;
    time = 1.0;
    return Outcome::settled;
  }
  const Vec3 seen = centre_ + (to - centre_) * (kFar / (to - centre_).norm());
  is_descending_ = true;
  double part = 0.0;
  outcome = follow_near(seen, seen, part);
  if (outcome != Outcome::settled) return outcome;
  time = 1.0;
  if (touching_ == 0) centre_ = to;
  return outcome;
}

SphereFollower::Outcome SphereFollower::follow_near(const Vec3& from, const Vec3& to, double& time) noexcept {
  least_distance_ = std::numeric_limits<double>::infinity();
  const Vec3 start = centre_;
  const double began = time;
  Next next = Next::again;
  int most = kLeastWork;
  bool has_touched = false;
  while (next == Next::again && work_ <= most) {
    ++events_;
    ++work_;
    if (!has_touched && touching_ != 0) {
      has_touched = true;
      most = most_work(from, to);
    }
    if (idle_ > kMostIdle && !(is_point_ && pass_by(from, to, time))) break;
    if (touching_ == 0) {
      next = fly(from, to, time);
    } else if (has_friction_ && rubs()) {
      next = is_descending_ ? descend_rubbing(on_path(from, to, time), to - from)
             : rub_.drags   ? drag(from, to, time)
                            : stay_rubbing(from, to, time);
    } else {
      next = is_descending_ ? descend(on_path(from, to, time), to - from) : slide(from, to, time);
    }
    if (next == Next::wait) next = wait(from, to, time);
    if (next == Next::settled && !(has_friction_ && rubs()) && leave_rest(to, to - from)) next = Next::again;
  }
  looked_at_ += static_cast<std::uint64_t>(work_);
  const bool has_stuck = has_friction_ && centre_ == start;
  if (touching_ != 0 && !has_stuck && !is_clear_here(2.0 * keep_.slop)) {
    centre_ = start;
    count_ = 0;
    touching_ = 0;
    time = began;
    return Outcome::unclear;
  }
  if (next == Next::unclear || idle_ > kMostIdle) return Outcome::unclear;
  note_multipliers(to);
  Vec3 way;
  if (next == Next::settled) return !is_point_ && !(has_friction_ && rubs()) && is_shallow(to, way) ? Outcome::unclear : Outcome::settled;
  is_descending_ = true;
  return Outcome::exhausted;
}

// What leads no nearer, event after event, is a place that rounding cannot tell from a minimum: a little later it is told, or the device
// has arrived.
bool SphereFollower::pass_by(const Vec3& from, const Vec3& to, double& time) noexcept {
  const double length = (to - from).norm();
  if (time >= 1.0 || !(length > 0.0) || passes_ > kMostPasses) return false;
  time = std::min(1.0, time + std::ldexp(4.0 * kAtAxis, passes_) / length);
  ++passes_;
  idle_ = 0;
  is_descending_ = touching_ != 0;
  return true;
}

int SphereFollower::most_work(const Vec3& from, const Vec3& to) const noexcept {
  const double length = (to - from).norm() + 2.0 * (from - centre_).norm();
  const double work = kLeastWork + kWorkPerEdge * geometry_.edges_per_length(contacts_[0].triangle) * length;
  return static_cast<int>(std::min(work, static_cast<double>(kMostWork)));
}

// To the device, straight, and on with it.
SphereFollower::Next SphereFollower::fly(const Vec3& from, const Vec3& to, double& time) noexcept {
  ++flights_;
  const Vec3 device = on_path(from, to, time);
  double until = 1.0;
  if (centre_ != device) {
    const Next next = fly_to(device, until);
    if (next != Next::settled || time >= 1.0) return next;
    return Next::again;
  }
  const Next next = fly_to(to, until);
  if (next != Next::settled) time = std::min(1.0, time + until * (1.0 - time));
  return next;
}

// Settled: there. Again: something was met on the way.
SphereFollower::Next SphereFollower::fly_to(const Vec3& to, double& until) noexcept {
  const double kDeepest = std::min(0x1p-28, 0.25 * keep_.offset);  // a centre nearer by more to what stops it was never put in contact
  const Clearance clearance{keep_.offset, keep_.slop, keep_.tolerance};
  const Vec3 from = centre_;
  const Vec3 motion = to - from;
  std::uint32_t first = 0;
  double time = kNever;
  geometry_.visit_along(from, to, keep_.offset + keep_.tolerance, [&](std::uint32_t id, double before) {
    ++work_;
    const double t = time_to_block(TriangleView{geometry_, id}, from, motion, std::min(before, time), clearance);
    if (!(t < time) || t > 1.0) return before;
    const ObjectGeometry::Corners corners = geometry_.corners(id);
    if (!materials_[geometry_.mesh_of(id)].two_sided && !can_touch(id, ContactTriangle(corners.a, corners.b, corners.c), from))
      return before;
    first = id;
    time = t;
    return std::min(before, t);
  });
  if (time > 1.0) {
    centre_ = to;
    rub_ = {};
    return Next::settled;
  }
  centre_ = from + time * motion;
  until = time;
  ++idle_;
  if (time * motion.norm() > kStill) idle_ = 0;
  least_distance_ = std::numeric_limits<double>::infinity();
  const ObjectGeometry::Corners corners = geometry_.corners(first);
  const ContactTriangle shape(corners.a, corners.b, corners.c);
  if (shape.separation(centre_).distance < keep_.offset - kDeepest) return Next::unclear;
  hint_ = motion;
  is_descending_ = true;
  return add_contact(OffsetContact::nearest(first, shape, centre_)) ? Next::again : Next::unclear;
}

bool SphereFollower::add_contact(const OffsetContact& contact) noexcept {
  int at = touching_;
  for (int i = 0; i < touching_; ++i) {
    if (contacts_[i].triangle == contact.triangle) at = i;
  }
  if (at == kMostContacts) return false;
  contacts_[at] = contact;
  if (at == touching_) ++touching_;
  return true;
}

void SphereFollower::remove_contact(int i) noexcept {
  for (int k = i + 1; k < touching_; ++k) contacts_[k - 1] = contacts_[k];
  --touching_;
  count_ = std::min(count_, touching_);
}

// What was met before and does not hold is met again if it is in the way.
void SphereFollower::note_move(const Vec3& from) noexcept {
  ++idle_;
  if ((centre_ - from).norm() > kStill) touching_ = count_;
}

// It gets on where it comes nearer to the device than it was while the device was there, or the device moves.
void SphereFollower::note_gain(const Vec3& device, bool has_moved) noexcept {
  const double distance = (device - centre_).norm();
  if (has_moved || distance < least_distance_ - kLeastGain) idle_ = 0;
  if (has_moved || distance < least_distance_) least_distance_ = distance;
}

// Which of what it touches hold the centre against the pull, brought to the front, and the way that they leave. What balances is decided by
// where the device goes.
bool SphereFollower::find_active(const Vec3& pull, const Vec3& motion, Vec3& way) noexcept {
  const double length = motion.norm();
  const Vec3 goal = length > 0.0 ? Vec3(pull + motion * (kNudge / length)) : pull;
  if (touching_ == 1) {
    const Vec3 normal = contacts_[0].stand(centre_).normal;
    const double height = normal.dot(goal);
    count_ = height < 0.0 ? 1 : 0;
    way = goal - height * normal;
    return true;
  }
  std::array<ContactPlane, kMostContacts> planes;
  for (int i = 0; i < touching_; ++i) planes[i] = {contacts_[i].stand(centre_).normal, 0.0};
  const ConstrainedMotion held = constrain_motion(goal, std::span<const ContactPlane>(planes.data(), static_cast<std::size_t>(touching_)));
  if (!held.solved) return false;
  way = held.motion;
  count_ = held.active_count;
  std::array<int, 3> at = held.active;
  for (int i = 0; i < count_; ++i) {
    if (at[i] == i) continue;
    std::swap(contacts_[i], contacts_[at[i]]);
    for (int j = i + 1; j < count_; ++j) {
      if (at[j] == i) at[j] = at[i];  // it was moved to make room
    }
  }
  return true;
}

// With the device held: one piece of the steepest way, or it has settled.
SphereFollower::Next SphereFollower::descend(const Vec3& device, const Vec3& motion) noexcept {
  const Vec3 pull = device - centre_;
  Vec3 way;
  if (!find_active(pull, motion, way)) return Next::unclear;
  if (count_ == 0) {
    touching_ = 0;
    ++idle_;
    return Next::again;
  }

  bool is_unstable = false;
  if (count_ == 3 || way.norm() <= kLeastWay) {
    is_unstable = count_ < 3 && !is_on_axis(device) && (has_lost_minimum_ || find_stability(centre_, device) <= 0.0);
    if (!is_unstable) {
      hold_against(device, motion);
      is_descending_ = false;
      touching_ = count_;
      return Next::again;
    }
  }
  has_lost_minimum_ = false;
  if (is_unstable && !find_way_off(motion)) {
    is_descending_ = false;
    touching_ = count_;
    return Next::again;
  }
  CentrePath path;
  if (!make_descent(device, is_unstable, path)) {
    if (!is_unstable) return count_ == 2 && is_point_ ? drop_weaker(pull) : Next::unclear;
    is_descending_ = false;
    touching_ = count_;
    ++idle_;
    return Next::wait;
  }
  Event event;
  if (!find_event(path, event)) return Next::unclear;
  const Vec3 before = centre_;
  bool is_restored = true;
  place_at_event(path, event, [&](double share) {
    centre_ = path.at(share);
    is_restored = restore(centre_);
  });
  if (!is_restored) {
    centre_ = before;
    return count_ == 2 && is_point_ ? drop_weaker(pull) : Next::unclear;
  }
  note_move(before);
  note_gain(device, false);
  // Over a face it comes to rest at the end.
  const bool is_at_rest = event.time >= 1.0 && event.contact < 0 && event.slot < 0 && touching_ == 1 && contacts_[0].part == Part::face;
  if (is_at_rest) is_descending_ = false;
  return take_event(event, path) ? Next::again : Next::unclear;
}

// Two that are too nearly one for a way between them: the one that holds less is met again if it is in the way.
SphereFollower::Next SphereFollower::drop_weaker(const Vec3& pull) noexcept {
  const double first = contacts_[0].stand(centre_).normal.dot(pull);
  const double second = contacts_[1].stand(centre_).normal.dot(pull);
  remove_contact(first < second ? 1 : 0);
  touching_ = count_;
  ++idle_;
  return Next::again;
}

// With the device moving: until the end of its motion, or the next event.
SphereFollower::Next SphereFollower::slide(const Vec3& from, const Vec3& to, double& time) noexcept {
  count_ = touching_;
  if (count_ == 3) return stay(from, to, time);
  Leg leg;
  if (!make_leg(from, to, time, leg)) {  // the minimum vanishes here
    has_lost_minimum_ = true;
    is_descending_ = true;
    hint_ = find_rate(centre_, on_path(from, to, time), to - from);
    if (!hint_.allFinite() || hint_.isZero(0.0)) hint_ = to - from;
    ++idle_;
    return Next::again;
  }
  Event event;
  if (!find_event(leg.path, event)) return Next::unclear;
  const Vec3 before = centre_;
  const double was = time;
  const bool is_whole = event.time >= 1.0;
  bool is_restored = true;
  place_at_event(leg.path, event, [&](double share) {
    time = share >= 1.0 ? leg.time : was + share * (leg.time - was);
    centre_ = leg.path.at(share);
    if (leg.path.is_straight() || solve(on_path(from, to, time), centre_)) return;
    centre_ = leg.path.at(share);
    is_restored = restore(centre_);
  });
  if (!is_restored) return Next::unclear;
  note_move(before);
  if ((time - was) * (to - from).norm() > kStill) note_gain(on_path(from, to, time), true);
  if (const auto next = end_leg(leg.path, event, is_whole, leg.released, on_path(from, to, time))) return *next;
  return time >= 1.0 ? Next::settled : Next::again;
}

// After a leg: what its event, or the contact that is released at its end, leads to. None: the leg went on to its end.
std::optional<SphereFollower::Next> SphereFollower::end_leg(const CentrePath& path, const Event& event, bool is_whole, int released,
                                                            const Vec3& device) noexcept {
  if (!take_event(event, path)) return Next::unclear;
  if (event.contact >= 0 || event.slot >= 0 || !is_whole) return Next::again;
  if (released < 0) return std::nullopt;
  ++idle_;
  remove_contact(released);
  if (touching_ == 0) centre_ = device;
  is_descending_ = touching_ != 0;
  return Next::again;
}

// From a place that no longer is a minimum: which way it leaves. By the hint, unless something touched is in the way there. False: it
// cannot leave.
bool SphereFollower::find_way_off(const Vec3& motion) noexcept {
  if (hint_.isZero(0.0)) hint_ = motion;
  ContactFrame frame;
  if (!find_frame(centre_, frame)) return true;
  Vec3 way = count_ == 2 ? Vec3(frame.along * (frame.along.dot(hint_) < 0.0 ? -1.0 : 1.0))
                         : Vec3(hint_ - frame.normal[0].dot(hint_) * frame.normal[0]);
  const auto is_open = [&](const Vec3& w) {
    for (int i = count_; i < touching_; ++i) {
      if (contacts_[i].stand(centre_).normal.dot(w) < 0.0) return false;
    }
    return true;
  };
  for (const double sign : {1.0, -1.0}) {
    if (!is_open(sign * way)) continue;
    hint_ = sign * way;
    return true;
  }
  return false;
}

}  // namespace hapton
