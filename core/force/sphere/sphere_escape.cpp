// A small sphere that represents a point can be held where a point would not be. Here it leaves such a minimum: out of a corner along its
// faces, and over a barrier lower than the sphere.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "core/force/contact_qp.h"
#include "core/force/sphere/sphere_follower.h"

namespace hapton {
namespace {

constexpr double kAround = 32.0;      // offsets; a corner within this distance is where the point is
constexpr double kWedge = 4096.0;     // offsets; so far from its tip a wedge of a fortieth of a degree holds the sphere
constexpr double kThrough = 4.0;      // offsets; a triangle this near to the corner touches it, and a crack this narrow is closed
constexpr double kLeastBetter = 2.0;  // offsets; a smaller gain is no escape
constexpr double kAbove = 1.25;       // offsets above the faces on the path
constexpr double kWide[] = {32.0, 512.0, 8192.0};         // offsets; radius of the path around the corner
constexpr double kMostOff = 4.0;                          // a position off an edge is this many times as far from the corner
constexpr double kHeights[] = {8.0, 32.0};                // offsets; height of a lift
constexpr int kMostTries = 2;                             // per step
constexpr double kHigher = (kAbove + kThrough) / kAbove;  // above displaced copies of these faces, too

// The position nearest to the planes, lines and points of contacts on faces, edges and vertices: the sum of the squared distances from them
// is least. False: it is not unique within rounding, or farther than `within` from one of them.
bool find_meeting(std::span<const OffsetContact> contacts, const Vec3& near, double within, Vec3& meeting) {
  constexpr double kLeastVolume = 0x1p-44;
  Mat3 sum = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const OffsetContact& contact : contacts) {
    Mat3 across = Mat3::Identity();
    if (contact.part == OffsetContact::Part::face) across = contact.normal * contact.normal.transpose();
    if (contact.part == OffsetContact::Part::edge) across -= contact.axis() * contact.axis().transpose();
    sum += across;
    right += across * (contact.origin() - near);
  }
  if (!(sum.determinant() > kLeastVolume)) return false;
  const Vec3 off = sum.inverse() * right;
  meeting = near + off;
  return std::all_of(contacts.begin(), contacts.end(),
                     [&](const OffsetContact& contact) { return std::fabs(contact.proximity(meeting).distance) <= within; });
}

}  // namespace

// The vertex near the centre, or the point where three faces that hold the centre meet, or the vertex that three contacts have in common:
// in a narrow corner the centre is far from it.
bool SphereFollower::find_apex(Vec3& apex) const noexcept {
  double nearest = kAround * clearance().offset;
  bool any = false;
  for (int i = 0; i < contacts_.count(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const Vec3& corner = contacts_[i].shape.corner(k);
      const double distance = (corner - centre_).norm();
      if (!(distance < nearest)) continue;
      nearest = distance;
      apex = corner;
      any = true;
    }
  }
  if (any) return true;
  ContactFrame frame;
  if (contacts_.active_count() != 3 || !contacts_.find_frame(centre_, frame)) return false;
  const auto is_face = [](const OffsetContact& contact) { return contact.part == OffsetContact::Part::face; };
  if (!std::all_of(contacts_.active().begin(), contacts_.active().end(), is_face)) {
    return find_common_corner(apex) || (find_meeting(contacts(), centre_, 0.5 * kThrough * clearance().offset, apex) &&
                                        (apex - centre_).norm() <= kWedge * clearance().offset);
  }
  apex = centre_;
  for (int i = 0; i < 3; ++i) apex -= clearance().offset * frame.dual[i];
  return (apex - centre_).norm() <= kWedge * clearance().offset;
}

bool SphereFollower::find_common_corner(Vec3& apex) const noexcept {
  for (int k = 0; k < 3; ++k) {
    const Vec3& corner = contacts_[0].shape.corner(k);
    const auto has_it = [&](const OffsetContact& contact) {
      return contact.shape.corner(0) == corner || contact.shape.corner(1) == corner || contact.shape.corner(2) == corner;
    };
    if (!((corner - centre_).norm() <= kWedge * clearance().offset)) continue;
    if (!std::all_of(contacts_.active().begin(), contacts_.active().end(), has_it)) continue;
    apex = corner;
    return true;
  }
  return false;
}

// The directions in which the point could leave its corner, as found for a centre no farther from this one than `moved`. False: there is no
// corner, or its boundary is not found.
bool SphereFollower::find_cone(double moved) noexcept {
  if ((centre_ - cone_at_).norm() <= moved) return has_cone_;
  cone_at_ = centre_;
  has_cone_ = false;
  Vec3 apex;
  if (!find_apex(apex)) return false;
  const double near = kThrough * clearance().offset;
  const double radius = near + (apex - centre_).norm();
  if (!near_.covers(centre_, radius) && (!near_.gather(centre_, Vec3::Zero(), work_) || !near_.covers(centre_, radius))) return false;
  cone_.begin(apex);
  bool fits = true;
  bool is_between = false;
  near_.visit_near(apex, apex, near, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (!(shape.separation(apex).distance <= near) || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    fits = fits && cone_.add(shape, near);
    const double above_plane = shape.normal().dot(centre_ - shape.corner(0));
    is_between |= above_plane * shape.normal().dot(centre_ - apex) < 0.0;
    ++work_;
  });
  Vec3 beside = centre_;
  fits = fits && (!is_between || find_beside(apex, beside));
  has_cone_ = fits && cone_.find_boundary((beside - apex).normalized());
  return has_cone_;
}

// The cone has the planes of all faces go through the apex. A face beyond the apex, nearer than kThrough, then passes the centre, which
// seems to be on its other side. Finds the nearest position that is on the same side of these planes as the centre is of the faces. It is
// in the ball around the centre that no triangle reaches. False: there is none.
bool SphereFollower::find_beside(const Vec3& apex, Vec3& beside) noexcept {
  constexpr double kClear = 0x1p-4;  // offsets from a plane
  constexpr int kMostFaces = 48;
  const double near = kThrough * clearance().offset;
  std::array<ContactPlane, kMostFaces> planes;
  int count = 0;
  bool fits = true;
  bool is_between = false;
  near_.visit_near(apex, apex, near, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (!(shape.separation(apex).distance <= near) || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    ++work_;
    const Separation at = shape.separation(centre_);
    if (at.feature != Feature::face) return;
    const double height = at.normal.dot(centre_ - apex);
    is_between |= height < 0.0;
    fits = fits && count < kMostFaces;
    if (fits) planes[static_cast<std::size_t>(count++)] = {at.normal, kClear * clearance().offset - height};
  });
  if (!fits || !is_between) return fits;
  const ConstrainedMotion aside =
      constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes.data(), static_cast<std::size_t>(count)));
  beside = centre_ + aside.motion;
  return aside.solved && aside.motion.norm() < clearance().offset;
}

// The least distance along an edge of the corner that makes the point come nearer to the device by kLeastBetter.
double SphereFollower::least_corner_exit(const Vec3& pull) const noexcept {
  return std::sqrt(8.0 * kLeastBetter * clearance().offset * pull.norm());
}

// The time at which an edge of the corner first leads nearer to the device; 2: none does.
double SphereFollower::time_to_corner_exit(const Vec3& from, const Vec3& to, double time) noexcept {
  if (!is_point_ || corner_tries_ >= kMostTries || !find_cone(4.0 * clearance().offset)) return 2.0;
  const Vec3 pull = from - cone_.apex();
  const Vec3 pull_then = to - cone_.apex();
  const double least = 1.0625 * std::max(least_corner_exit(pull), least_corner_exit(pull_then));
  double soonest = 2.0;
  for (const TangentCone::Piece& piece : cone_.boundary()) {
    const double there = piece.to.dot(pull_then) - least;
    if (!(there > 0.0)) continue;
    const double here = std::min(piece.to.dot(pull) - least, 0.0);
    soonest = std::min(soonest, std::max(time, here / (here - there)));
  }
  return soonest;
}

// In the steepest direction that has room: a slit between sheets that touch has none. Where no direction on the boundary leads nearer, the
// pull itself may be free: the sphere is in a fold of the corner, and the point at the apex is not.
bool SphereFollower::leave_corner(const Vec3& device, const Vec3& motion) noexcept {
  constexpr int kMostDirections = 8;
  const Vec3 pull = device - cone_.apex();
  TangentCone::Steepest steepest = cone_.find_steepest(pull);
  // At the end of a groove that leads neither in nor out, the point stays.
  if (steepest.slope < -least_corner_exit(pull)) return cone_.is_reentrant() && leave_fold(device, motion);
  for (int i = 0; i < kMostDirections && steepest.slope > least_corner_exit(pull); ++i) {
    const auto pass = [&](double radius) {
      return try_escape(device, motion, [&] {
        const std::optional<Vec3> target = find_past_corner(steepest, radius);
        return target && pass_corner(*target, radius);
      });
    };
    const auto pass_higher = [&](double radius) {
      return try_escape(device, motion, [&] {
        const std::optional<Vec3> target = find_past_corner(steepest, radius);
        if (!target) return false;
        const Vec3 below = cone_.apex() + radius * steepest.direction;
        const Vec3 off = kHigher * (*target - below);
        return kMostOff * off.norm() < radius && pass_corner(below + off, radius);
      });
    };
    for (const double wide : kWide) {
      const double radius = wide * clearance().offset;
      if (pass(radius)) return true;
      for (const bool ahead : {true, false}) {
        if (try_escape(device, motion, [&] { return fly_around_corner(steepest, radius, ahead); })) return true;
      }
      if (pass_higher(radius)) return true;
    }
    // A slit so narrow has room for the sphere only farther out.
    const double room = 1.25 * kMostOff * distance_off_edge(steepest);
    if (room > kWide[2] * clearance().offset && pass(room)) return true;
    steepest = cone_.find_steepest(pull, steepest.slope);
  }
  return false;
}

// Straight along the pull, past the apex.
bool SphereFollower::leave_fold(const Vec3& device, const Vec3& motion) noexcept {
  const Vec3 towards = (device - cone_.apex()).normalized();
  return cone_.contains(towards) && std::any_of(std::begin(kWide), std::end(kWide), [&](double wide) {
           const double radius = wide * clearance().offset;
           return try_escape(device, motion, [&] { return pass_corner(cone_.apex() + radius * towards, radius); });
         });
}

// Leaves a minimum in the steepest direction that leads to a nearer one. False, and nothing changed: no direction does, or work has run
// out before all were tried.
bool SphereFollower::leave_minimum(const Vec3& device, const Vec3& motion) noexcept {
  if (!is_point_ || contacts_.is_empty() || wedge().holds()) return false;
  escapes_ = 0;
  // The way out begins where the centre is.
  bool has_left = find_cone(0.0) && leave_corner(device, motion);
  if (!has_left && last_fly_over_ != motion_) {
    has_left = leave_by_flight(device, motion);
    if (!has_escapes_left_) last_fly_over_ = motion_;
  }
  if (!has_escapes_left_) failed_escapes_ = 0;
  return has_left;
}

// Over a barrier lower than the sphere, once in a motion.
bool SphereFollower::leave_by_flight(const Vec3& device, const Vec3& motion) noexcept {
  const auto leads_over = [&](const Vec3& direction) {
    return std::any_of(std::begin(kHeights), std::end(kHeights), [&](double height) {
      return try_escape(device, motion,
                        [&] { return fly_over(32.0 * height * clearance().offset * direction, height * clearance().offset); });
    });
  };
  Vec3 over;
  if (minimum().is_shallow(centre_, device, over) && leads_over(over)) return true;
  // Along each face that it touches, over the boundary of a crack as narrow as the sphere.
  const int touching = contacts_.count();
  for (int i = 0; i < touching; ++i) {
    const Vec3& normal = contacts_[i].shape.normal();
    const Vec3 pull = device - centre_;
    const Vec3 along = pull - normal.dot(pull) * normal;
    const double length = along.norm();
    if (!normal.isZero(0.0) && length > least_corner_exit(pull) && leads_over(along / length)) return true;
  }
  return false;
}

// How far from the boundary a position there is: at an edge, on the middle between its two pieces.
double SphereFollower::distance_off_edge(const TangentCone::Steepest& to) const noexcept {
  const TangentCone::Piece& piece = cone_.boundary()[static_cast<std::size_t>(to.piece)];
  const double half = to.direction == piece.to ? 0.5 * piece.opening : 0.5 * std::numbers::pi;
  return kAbove * clearance().offset / (half < 0.5 * std::numbers::pi ? std::sin(half) : 1.0);
}

// A position that far from the corner, in that direction and off the boundary. None: the boundary is too narrow there.
std::optional<Vec3> SphereFollower::find_past_corner(const TangentCone::Steepest& to, double wide) const noexcept {
  const TangentCone::Piece& piece = cone_.boundary()[static_cast<std::size_t>(to.piece)];
  const double half = to.direction == piece.to ? 0.5 * piece.opening : 0.5 * std::numbers::pi;
  const double off = distance_off_edge(to);
  if (!(kMostOff * off < wide)) return std::nullopt;
  return cone_.apex() + wide * to.direction + off * (std::cos(half) * piece.back + std::sin(half) * piece.normal);
}

// Moves the centre past the corner in one step, if all triangles near it go through the corner: the free space there is a cone. The target
// must be in the part of the cone that the centre is in: beside a narrow slit of it, a position off one side is beyond the other. Where the
// cone's boundary may be that of another part, nothing may be in between. And it must be on the same side of each face as of the plane
// through the apex that stands for it.
bool SphereFollower::pass_corner(const Vec3& target, double wide) noexcept {
  const Vec3& apex = cone_.apex();
  const double within = 1.25 * wide;
  if (!((centre_ - apex).norm() < wide) || !near_.covers(apex, within) || !cone_.contains((target - apex).normalized())) return false;
  bool is_free = true;
  near_.visit_near(apex, apex, within, [&](int slot) {
    ++work_;
    const ContactTriangle& shape = near_.shape(slot);
    const double distance = shape.separation(apex).distance;
    if (!is_free || distance > within || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    const Separation at = shape.separation(target);
    is_free = distance <= kThrough * clearance().offset && at.distance >= clearance().offset &&
              (at.feature != Feature::face || at.normal.dot(target - apex) > 0.0) &&
              (cone_.is_around_start() || near_.geometry().pierce(near_.triangle(slot), centre_, target).time > 1.0);
  });
  if (!is_free || is_beyond_surface(target, within)) return false;
  centre_ = target;
  return true;
}

// Where the surface around the corner is closed and oriented, a target is on its other side if the path there does not cross it as often in
// as out. Triangles smaller than the sphere are no sides of the cone, so its boundary may lead through them. False: it may also have an end
// there. Edges without an adjacent triangle that run to and fro, within what counts as a closed crack, are no end: they are left where
// needles were removed (touch_resolution.h).
bool SphereFollower::is_beyond_surface(const Vec3& target, double within) noexcept {
  const Vec3& apex = cone_.apex();
  Vec3 gap = Vec3::Zero();
  Vec3 area = Vec3::Zero();
  bool is_two_sided = true;
  int balance = 0;
  near_.visit_near(apex, apex, within, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (shape.separation(apex).distance > within) return;
    const std::uint32_t id = near_.triangle(slot);
    is_two_sided &= near_.material(id).two_sided;
    for (int k = 0; k < 3; ++k) {
      const TouchGeometry::Adjacent beside = near_.geometry().adjacent(id, k);
      if (beside.exists && !beside.flips) continue;
      const Span part = part_within(shape, k, apex, within);
      const Vec3 from = shape.corner(k) - apex + part.begin * shape.edge(k);
      const Vec3 along = (part.end - part.begin) * shape.edge(k);
      gap += along;
      area += 0.5 * from.cross(along);
    }
    const TouchGeometry::Hit hit = near_.geometry().pierce(id, centre_, target);
    if (hit.time <= 1.0) balance += hit.from_back ? 1 : -1;
  });
  const double crack = kThrough * clearance().offset;
  return balance != 0 && is_two_sided && gap.norm() <= crack && area.norm() <= crack * within;
}

// The shares of edge k between which it is that near to p; an empty span if it is nowhere.
SphereFollower::Span SphereFollower::part_within(const ContactTriangle& shape, int k, const Vec3& p, double within) {
  const double middle = shape.along(k, p);
  const double squared = within * within - (shape.corner(k) + middle * shape.edge(k) - p).squaredNorm();
  if (!(squared > 0.0) || !(shape.length(k) > 0.0)) return {0.0, 0.0};
  const double half = std::sqrt(squared) / shape.length(k);
  const double begin = std::clamp(middle - half, 0.0, 1.0);
  return {begin, std::max(begin, std::min(1.0, middle + half))};
}

// Around the corner, a little above the faces of its boundary, to the direction that leads on.
bool SphereFollower::fly_around_corner(const TangentCone::Steepest& to, double wide, bool ahead) noexcept {
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  const std::span<const TangentCone::Piece> boundary = cone_.boundary();
  const int count = static_cast<int>(boundary.size());
  const double above = kAbove * clearance().offset;
  const auto go = [&](const Vec3& to_apex) { return fly_straight(cone_.apex() + to_apex - centre_, 1.0); };
  // Around the edge at the end of a piece, by less than a quarter turn at a time.
  const auto fly_about_edge = [&](const TangentCone::Piece& piece, bool forward) {
    const int steps = std::max(1, static_cast<int>(std::ceil(piece.opening / kQuarter - 0x1p-20)));
    const double each = piece.opening / steps;
    const double off = above / std::sin(std::min(0.5 * each, 0.5 * kQuarter));
    if (!(off < 0.25 * wide)) return false;
    for (int i = 0; i < steps; ++i) {
      const double angle = each * ((forward ? i : steps - 1 - i) + 0.5);
      if (!go(wide * piece.to + off * (std::cos(angle) * piece.back + std::sin(angle) * piece.normal))) return false;
    }
    return true;
  };
  // Over a piece, so that the path does not cut across the corner.
  const auto fly_over_piece = [&](const TangentCone::Piece& piece, const Vec3& from, const Vec3& end) {
    const double angle = std::acos(std::clamp(from.dot(end), -1.0, 1.0));
    const int steps = static_cast<int>(angle / (0.5 * kQuarter));
    for (int i = 1; i <= steps; ++i) {
      const double share = static_cast<double>(i) / (steps + 1);
      if (!go(wide * ((1.0 - share) * from + share * end).normalized() + above * piece.normal)) return false;
    }
    return true;
  };
  const TangentCone::Piece& last = boundary[static_cast<std::size_t>(to.piece)];
  const bool is_edge = to.direction == last.to;
  if (!go(wide * boundary[0].from + above * boundary[0].normal)) return false;
  if (ahead) {
    for (int i = 0; i < to.piece; ++i) {
      if (!fly_over_piece(boundary[static_cast<std::size_t>(i)], boundary[static_cast<std::size_t>(i)].from,
                          boundary[static_cast<std::size_t>(i)].to) ||
          !fly_about_edge(boundary[static_cast<std::size_t>(i)], true))
        return false;
    }
    if (!fly_over_piece(last, last.from, to.direction)) return false;
  } else {
    for (int i = count - 1; i > to.piece; --i) {
      const TangentCone::Piece& piece = boundary[static_cast<std::size_t>(i)];
      if (!fly_over_piece(piece, piece.to, piece.from) || !fly_about_edge(boundary[static_cast<std::size_t>(i - 1)], false)) return false;
    }
    if (!fly_over_piece(last, last.to, to.direction)) return false;
  }
  return is_edge ? !ahead || fly_about_edge(last, true) : go(wide * to.direction + above * last.normal);
}

// Up over everything near, then along the displacement.
bool SphereFollower::fly_over(const Vec3& displacement, double height) noexcept {
  const Vec3 from = centre_;
  const Vec3 up = find_lift(height);
  if (up.isZero(0.0) || !fly_straight(up, 1.0)) return false;
  fly_straight(displacement, 0.0);
  return (centre_ - from).norm() >= 4.0 * height;
}

// Moves along the path of `go`, then descends with the device held, until the centre is nearer to the device than before; a descent never
// moves away from the device. Returns false, with the state restored, if the centre does not come nearer, if this escape failed before, or
// if work has run out. An escape that had half of a step's work is not tried again.
template <class Go>
bool SphereFollower::try_escape(const Vec3& device, const Vec3& motion, Go&& go) noexcept {
  constexpr int kMostEvents = 256;
  if (has_escapes_left_ || escapes_++ < failed_escapes_) return false;
  const int work_before = work_;
  const Vec3 centre = centre_;
  const auto contacts = contacts_;
  const double distance = (device - centre_).norm();
  const double nearer = distance - kLeastBetter * clearance().offset;
  const auto end = [&](bool is_better) {
    idle_ = 0;
    if (is_better) return true;
    has_escapes_left_ = work_ > most_work_ && 2 * work_before > most_work_;
    failed_escapes_ += has_escapes_left_ ? 0 : 1;
    centre_ = centre;
    contacts_ = contacts;
    is_descending_ = false;
    has_lost_minimum_ = false;
    least_distance_ = std::numeric_limits<double>::infinity();
    return false;
  };
  contacts_.clear();
  idle_ = 0;
  if (!go()) return end(false);
  hint_ = centre_ - centre;
  is_descending_ = true;
  least_distance_ = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMostEvents && idle_ <= kMostIdle && work_ <= most_work_ && !((device - centre_).norm() < nearer); ++i) {
    work_ += kWorkOfEvent;
    double until = 1.0;
    if (!contacts_.is_empty() && !is_descending_) break;
    const Next next = contacts_.is_empty() ? fly_to(device, until) : descend(device, motion);
    if (next == Next::settled) break;
    if (next != Next::again) return end(false);
  }
  return end((device - centre_).norm() < nearer);
}

// The shortest displacement that is `height` above everything near.
Vec3 SphereFollower::find_lift(double height) noexcept {
  constexpr int kMostNear = 48;
  std::array<ContactPlane, kMostNear> planes;
  int count = 0;
  const double near = 2.0 * height;
  if (!near_.covers(centre_, near) && (!near_.gather(centre_, Vec3::Zero(), work_) || !near_.covers(centre_, near))) return Vec3::Zero();
  near_.visit_near(centre_, centre_, near, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    const Separation at = shape.separation(centre_);
    if (count == kMostNear || at.distance > near || !near_.can_touch(near_.triangle(slot), shape, centre_)) return;
    planes[static_cast<std::size_t>(count++)] = {at.normal, height - at.distance};
  });
  work_ += count;
  const ConstrainedMotion up =
      constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes.data(), static_cast<std::size_t>(count)));
  return up.solved && up.motion.norm() <= 64.0 * height ? up.motion : Vec3(Vec3::Zero());
}

// Flies straight until something is hit. False: before that share of the motion.
bool SphereFollower::fly_straight(const Vec3& motion, double share) noexcept {
  const CentrePath path = CentrePath::straight(centre_, centre_ + motion);
  Event event;
  if (!events_on().find(path, event)) return false;
  centre_ = path.at(event.time);
  return event.time >= share;
}

}  // namespace hapton
