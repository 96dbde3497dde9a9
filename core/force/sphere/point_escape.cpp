// A small sphere that represents a point can be held in a local minimum that does not exist for the point: in a corner that only the
// sphere's radius closes, or behind a barrier lower than the sphere. These functions find a path out of it.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "core/force/contact_qp.h"
#include "core/force/sphere/sphere_follower.h"

namespace hapton {
namespace {

constexpr double kPathRadii[] = {32.0, 512.0, 8192.0};  // offsets; radius of the path around the corner
constexpr double kLiftHeights[] = {8.0, 32.0};          // offsets; height of a lift
constexpr double kAboveCopies =
    (CornerExit::kAbove + CornerExit::kThrough) / CornerExit::kAbove;  // in units of kAbove: above faces moved by kThrough, too

}  // namespace

// Leaves the corner in the steepest direction in which the sphere fits. Between two sheets that touch, it does not fit. `pull` is the
// vector from the apex to the device. If no direction on the boundary of the free space leads nearer to the device, the direction of the
// pull itself may be free. This is so at a reentrant corner that holds the sphere beside the apex, but would not hold a point at the apex.
bool SphereFollower::leave_corner(const Vec3& device, const Vec3& motion) noexcept {
  constexpr int kMaxDirections = 8;  // directions tried in one call; a free choice
  const Vec3 pull = device - corner_.cone.apex();
  TangentCone::Steepest steepest = corner_.cone.find_steepest(pull);
  // At the end of a groove, where no direction leads nearer by more than rounding, the point stays.
  if (steepest.slope < -corner().least_exit(pull)) return corner_.cone.is_reentrant() && leave_reentrant_corner(device, motion);
  for (int i = 0; i < kMaxDirections && steepest.slope > corner().least_exit(pull); ++i) {
    const auto pass = [&](double radius, bool is_higher) {
      return try_escape(device, motion, [&] {
        const std::optional<Vec3> target = corner().find_past(steepest, radius);
        if (!target || !is_higher) return target && move_past_corner(*target, radius);
        const Vec3 below = corner_.cone.apex() + radius * steepest.direction;
        const Vec3 off = kAboveCopies * (*target - below);
        return CornerExit::kMaxOff * off.norm() < radius && move_past_corner(below + off, radius);
      });
    };
    for (const double offsets : kPathRadii) {
      const double radius = offsets * clearance().offset;
      if (pass(radius, false)) return true;
      for (const bool ahead : {true, false}) {
        if (try_escape(device, motion, [&] { return fly_around_corner(steepest, radius, ahead); })) return true;
      }
      if (pass(radius, true)) return true;
    }
    // In a slit that is too narrow for these radii, the sphere fits only farther from the apex.
    const double wide_radius = 1.25 * CornerExit::kMaxOff * corner().distance_off_edge(steepest);
    if (wide_radius > kPathRadii[2] * clearance().offset && pass(wide_radius, false)) return true;
    steepest = corner_.cone.find_steepest(pull, steepest.slope);
  }
  return false;
}

// Moves straight along the pull, past the apex.
bool SphereFollower::leave_reentrant_corner(const Vec3& device, const Vec3& motion) noexcept {
  const Vec3 towards = (device - corner_.cone.apex()).normalized();
  return corner_.cone.contains(towards) && std::ranges::any_of(kPathRadii, [&](double offsets) {
           const double radius = offsets * clearance().offset;
           return try_escape(device, motion, [&] { return move_past_corner(corner_.cone.apex() + radius * towards, radius); });
         });
}

// Leaves a minimum in the steepest direction that leads to another minimum, nearer to the device. False, with the state unchanged: no
// direction does, or the work limit was reached before all were tried (has_untried_escapes_). The next call then continues with the first
// direction not tried: those before it may cost most of the work of a call.
bool SphereFollower::leave_minimum(const Vec3& device, const Vec3& motion) noexcept {
  if (!is_point_ || contacts_.is_empty()) return false;
  resumes_escapes_ = untried_escapes_at_ == centre_;
  if (!resumes_escapes_ && wedge().holds()) return false;
  escapes_reached_ = 0;
  // 0: the corner must be that of this very centre, because the path out begins here.
  bool has_left = corner().find_cone(0.0) && leave_corner(device, motion);
  if (!has_left && last_fly_over_ != motion_) {
    has_left = leave_slit_sideways(device, motion) || leave_by_flight(device, motion);
    if (!has_untried_escapes_) last_fly_over_ = motion_;
  }
  if (has_untried_escapes_) untried_escapes_at_ = centre_;
  if (!has_untried_escapes_) failed_escapes_ = 0;
  return has_left;
}

// Leaves the minimum over a barrier lower than the sphere. Called at most once in a motion of the device.
bool SphereFollower::leave_by_flight(const Vec3& device, const Vec3& motion) noexcept {
  const auto leads_over = [&](const Vec3& direction) {
    return std::ranges::any_of(kLiftHeights, [&](double height) {
      return try_escape(device, motion,
                        [&] { return fly_over(32.0 * height * clearance().offset * direction, height * clearance().offset); });
    });
  };
  Vec3 over;
  if (minimum().is_shallow(centre_, device, over) && leads_over(over)) return true;
  // Tries to fly along each face in contact, over the boundary of a crack as narrow as the sphere, or over a ridge beyond which the surface
  // falls away. So even a short way to the projection of the device on the face may gain much.
  const int contact_count = contacts_.count();
  for (int i = 0; i < contact_count; ++i) {
    const Vec3& normal = contacts_[i].shape.normal();
    const Vec3 pull = device - centre_;
    const Vec3 along = pull - normal.dot(pull) * normal;
    const double length = along.norm();
    if (!normal.isZero(0.0) && length > LocalMinimum::kAtMinimum && leads_over(along / length)) return true;
  }
  return false;
}

// Leaves over the boundary of a face that holds the centre in a slit: it is at a minimum over the faces, but the slit is wider beyond them.
bool SphereFollower::leave_slit_sideways(const Vec3& device, const Vec3& motion) noexcept {
  constexpr double kBeyond = 32.0;  // offsets; a free choice
  if (!is_in_narrow_slit()) return false;
  for (int i = 0; i < contacts_.active_count(); ++i) {
    const ContactTriangle face = contacts_[i].shape;
    for (int k = 0; k < 3 && !face.normal().isZero(0.0); ++k) {
      const Vec3 outwards = PathEvents::edge_of(face, k).direction;
      if (!(std::fabs(outwards.dot(centre_ - face.corner(k))) <= kBalance)) continue;
      const auto go = [&] {
        fly_straight(kBeyond * clearance().offset * outwards, 0.0);
        return true;
      };
      if (try_escape(device, motion, go)) return true;
    }
  }
  return false;
}

bool SphereFollower::move_past_corner(const Vec3& target, double radius) noexcept {
  if (!corner().can_pass(target, radius)) return false;
  centre_ = target;
  return true;
}

// Moves around the corner at the distance `radius` from the apex, a little above the faces of its boundary, to the direction `to`. ahead:
// true: in the order of the pieces of the boundary; false: against it.
bool SphereFollower::fly_around_corner(const TangentCone::Steepest& to, double radius, bool ahead) noexcept {
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  const std::span<const TangentCone::Piece> boundary = corner_.cone.boundary();
  const int count = static_cast<int>(boundary.size());
  const double above = CornerExit::kAbove * clearance().offset;
  const auto go = [&](const Vec3& to_apex) { return fly_straight(corner_.cone.apex() + to_apex - centre_, 1.0); };
  // Flies around the edge at the end of a piece, by at most a quarter turn at a time.
  const auto fly_about_edge = [&](const TangentCone::Piece& piece, bool forward) {
    const int steps = std::max(1, static_cast<int>(std::ceil(piece.opening / kQuarter - 0x1p-20)));
    const double each = piece.opening / steps;
    const double off = above / std::sin(std::min(0.5 * each, 0.5 * kQuarter));
    if (!(off < 0.25 * radius)) return false;
    for (int i = 0; i < steps; ++i) {
      const double angle = each * ((forward ? i : steps - 1 - i) + 0.5);
      if (!go(radius * piece.to + off * (std::cos(angle) * piece.back + std::sin(angle) * piece.normal))) return false;
    }
    return true;
  };
  // Flies over a piece in steps, so that the path does not cut across the corner.
  const auto fly_over_piece = [&](const TangentCone::Piece& piece, const Vec3& from, const Vec3& end) {
    const double angle = std::acos(std::clamp(from.dot(end), -1.0, 1.0));
    const int steps = static_cast<int>(angle / (0.5 * kQuarter));
    for (int i = 1; i <= steps; ++i) {
      const double share = static_cast<double>(i) / (steps + 1);
      if (!go(radius * ((1.0 - share) * from + share * end).normalized() + above * piece.normal)) return false;
    }
    return true;
  };
  const TangentCone::Piece& last = boundary[to.piece];
  const bool is_edge = to.direction == last.to;
  if (!go(radius * boundary[0].from + above * boundary[0].normal)) return false;
  const auto begin_of = [&](const TangentCone::Piece& piece) { return ahead ? piece.from : piece.to; };
  for (int i = ahead ? 0 : count - 1; i != to.piece; i += ahead ? 1 : -1) {
    const TangentCone::Piece& piece = boundary[i];
    if (!fly_over_piece(piece, begin_of(piece), ahead ? piece.to : piece.from)) return false;
    if (!fly_about_edge(ahead ? piece : boundary[i - 1], ahead)) return false;
  }
  if (!fly_over_piece(last, begin_of(last), to.direction)) return false;
  return is_edge ? !ahead || fly_about_edge(last, true) : go(radius * to.direction + above * last.normal);
}

// Moves up until it is above everything near, then along the displacement.
bool SphereFollower::fly_over(const Vec3& displacement, double height) noexcept {
  const Vec3 from = centre_;
  const Vec3 up = find_lift(height);
  if (up.isZero(0.0) || !fly_straight(up, 1.0)) return false;
  fly_straight(displacement, 0.0);
  return (centre_ - from).norm() >= 4.0 * height;
}

// Moves along the path of `go`, then descends with the device held, until the centre is nearer to the device than before; a descent never
// moves away from the device. Returns false, with the state restored, if the centre does not come nearer, if this escape failed before, or
// if the work limit was reached. In the last case it is tried again by the next call, unless it had at least half of a step's work or was
// the first one of a call that continues (resumes_escapes_): the next call might have no more work for it.
template <class Go>
bool SphereFollower::try_escape(const Vec3& device, const Vec3& motion, Go&& go) noexcept {
  constexpr int kMaxEvents = 256;  // events of one escape; bounds its work; a free choice
  if (has_untried_escapes_ || escapes_reached_++ < failed_escapes_) return false;
  const int work_before = work_;
  const bool is_last_try = resumes_escapes_;
  resumes_escapes_ = false;
  const Vec3 centre = centre_;
  const auto contacts = contacts_;
  const double distance = (device - centre_).norm();
  const double target_distance = distance - CornerExit::kMinGain * clearance().offset;
  const auto end = [&](bool is_better) {
    idle_events_ = 0;
    if (is_better) return true;
    has_untried_escapes_ = work_ > most_work_ && 2 * work_before > most_work_ && !is_last_try;
    failed_escapes_ += has_untried_escapes_ ? 0 : 1;
    centre_ = centre;
    contacts_ = contacts;
    is_descending_ = false;
    has_lost_minimum_ = false;
    least_distance_ = std::numeric_limits<double>::infinity();
    return false;
  };
  contacts_.clear();
  idle_events_ = 0;
  if (!go()) return end(false);
  direction_hint_ = centre_ - centre;
  is_descending_ = true;
  least_distance_ = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxEvents && idle_events_ <= kMaxIdleEvents && work_ <= most_work_ && !((device - centre_).norm() < target_distance);
       ++i) {
    work_ += kWorkOfEvent;
    double until = 1.0;
    if (!contacts_.is_empty() && !is_descending_) break;
    const Next next = contacts_.is_empty() ? fly_to(device, until) : descend(device, motion);
    if (next == Next::settled) break;
    if (next != Next::again) return end(false);
  }
  return end((device - centre_).norm() < target_distance);
}

// The shortest displacement after which the centre is `height` above everything near; zero if none is found.
Vec3 SphereFollower::find_lift(double height) noexcept {
  constexpr int kMaxNear = 48;  // planes; more are ignored; a free choice
  std::array<ContactPlane, kMaxNear> planes;
  int count = 0;
  const double near = 2.0 * height;
  if (!near_.reach(centre_, near, work_)) return Vec3::Zero();
  near_.visit_near(centre_, centre_, near, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    const Separation at = shape.separation(centre_);
    if (count == kMaxNear || at.distance > near || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    planes[count++] = {at.normal, height - at.distance};
  });
  work_ += count;
  const ConstrainedMotion up = constrain_motion(Vec3::Zero(), std::span(planes).first(count));
  return up.solved && up.motion.norm() <= 64.0 * height ? up.motion : Vec3(Vec3::Zero());
}

// Moves the centre straight until it touches a triangle. False: that is before the given share of the motion, or the search failed.
bool SphereFollower::fly_straight(const Vec3& motion, double share) noexcept {
  const CentrePath path = CentrePath::straight(centre_, centre_ + motion);
  Event event;
  if (!events_on().find(path, event)) return false;
  centre_ = path.at(event.time);
  return event.time >= share;
}

}  // namespace hapton
