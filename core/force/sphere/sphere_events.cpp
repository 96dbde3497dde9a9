// Contacts after an event on a piece of path; flights: a centre without contacts goes straight to the device, or until it hits a triangle.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/collision/swept_sphere.h"
#include "core/force/sphere/sphere_follower.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

constexpr double kMinRise = 0x1p-45;  // rad: two faces at a smaller angle count as one plane at their common edge

// Whether another triangle at an edge of the face lies beyond that edge. At the edge of a blade it is folded back under the face instead.
bool lies_beyond(const ContactTriangle& face, int edge, const ContactTriangle& other) {
  for (int k = 0; k < 3; ++k) {
    const Vec3& corner = other.corner(k);
    const bool is_end = corner == face.corner(edge) || corner == face.corner((edge + 1) % 3);
    if (!is_end && face.inside(edge, corner) < 0.0) return true;
  }
  return false;
}

}  // namespace

// Whether the centre is nearer to a triangle than a centre in contact can be.
bool SphereFollower::overlaps(const ContactTriangle& shape) const noexcept {
  return shape.separation(centre_).distance < clearance().offset - std::min(0x1p-28, 0.25 * clearance().offset);
}

// Changes the contacts as the event demands. False: the centre cannot be in contact with all of them, or there are too many.
bool SphereFollower::apply_event(const Event& event, const CentrePath& path) noexcept {
  if (event.contact >= 0) {
    is_descending_ = true;
    const bool is_coplanar =
        idle_events_ > kMaxIdleEvents / 4;  // treating it as rising made no progress: within rounding the faces are coplanar
    const int rising = event.exit.part == Feature::edge && !is_coplanar
                           ? find_rising(contacts_[event.contact], event.exit.index, path.slope(event.time))
                           : -1;
    if (rising >= 0)
      return contacts_.add(OffsetContact::on_face(near_.triangle(rising), near_.shape(rising), contacts_[event.contact].normal));
    if (const int level = event.exit.part == Feature::edge ? find_coplanar(contacts_[event.contact], event.exit) : -1; level >= 0) {
      direction_hint_ = path.slope(event.time);
      OffsetContact& contact = contacts_[event.contact];
      contact = OffsetContact::on_face(near_.triangle(level), near_.shape(level), contact.normal);
      return true;
    }
    move_to_next_part(event.contact, event.exit, path.slope(event.time));
    if (contacts_.is_held_twice(event.contact)) {
      contacts_.remove(event.contact);
      return true;
    }
    if (contacts_.restore(centre_, work_)) return true;
    if (!is_point_) return false;
    // No position fits this contact and the others: drops the others. They are hit again if they are in the way.
    contacts_.keep_only(event.contact);
    ++idle_events_;
    return contacts_.restore(centre_, work_);
  } else if (event.slot >= 0) {
    if (event.time <= 0.0 && overlaps(near_.shape(event.slot))) return false;
    direction_hint_ = path.slope(event.time);
    is_descending_ = true;
    return contacts_.add(OffsetContact::nearest(near_.triangle(event.slot), near_.shape(event.slot), centre_));
  }
  return true;
}

// Finds an adjacent face that rises beyond an edge by so little that it was not hit before. Returns its slot; -1: none.
int SphereFollower::find_rising(const OffsetContact& contact, int edge, const Vec3& direction) noexcept {
  if (contact.part != Feature::face) return -1;
  const OffsetContact shared_edge = OffsetContact::on_edge(contact.triangle, contact.shape, edge);
  int rising = -1;
  double least = -kMinRise * direction.norm();
  near_.visit_near(centre_, centre_, clearance().offset + clearance().slop, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (near_.triangle(slot) == contact.triangle || !shared_edge.is_shared_with(shape) ||
        !near_.can_touch(near_.triangle(slot), shape, centre_))
      return;
    const OffsetContact face = OffsetContact::on_face(near_.triangle(slot), shape, contact.normal);
    const double rise = face.normal.dot(direction);
    if (!(rise < least) || !lies_beyond(contact.shape, edge, shape) ||
        std::fabs(face.proximity(centre_).distance - clearance().offset) > clearance().slop)
      return;
    least = rise;
    rising = slot;
  });
  return rising;
}

// Finds an adjacent face that is coplanar: their common edge has no part of the offset surface. Returns its slot; -1: none.
int SphereFollower::find_coplanar(const OffsetContact& contact, const Exit& exit) noexcept {
  if (contact.part != Feature::face) return -1;
  const OffsetContact shared_edge = OffsetContact::on_edge(contact.triangle, contact.shape, exit.index);
  int level = -1;
  near_.visit_near(centre_, centre_, clearance().offset + clearance().slop, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (near_.triangle(slot) == contact.triangle || !shared_edge.is_shared_with(shape) ||
        !near_.can_touch(near_.triangle(slot), shape, centre_))
      return;
    if (!(shape.normal().cross(contact.normal).squaredNorm() <= kMinRise * kMinRise) || !PathEvents::is_over(shape, centre_)) return;
    if (events_on().is_level_at(OffsetContact::on_face(near_.triangle(slot), shape, contact.normal), centre_)) level = slot;
  });
  return level;
}

// Moves contact i to the part (face, edge or vertex) beyond the boundary that it crosses.
void SphereFollower::move_to_next_part(int i, const Exit& exit, const Vec3& direction) noexcept {
  OffsetContact& contact = contacts_[i];
  direction_hint_ = direction;
  const Vec3 normal = contact.proximity(centre_).normal;
  const std::uint32_t triangle = exit.slot < 0 ? contact.triangle : near_.triangle(exit.slot);
  const ContactTriangle shape = exit.slot < 0 ? contact.shape : near_.shape(exit.slot);
  contact = exit.part == Feature::face   ? OffsetContact::on_face(triangle, shape, normal)
            : exit.part == Feature::edge ? OffsetContact::on_edge(triangle, shape, exit.index)
                                         : OffsetContact::on_vertex(triangle, shape, exit.index);
}

// Flies straight to the device; a centre that is already there flies on with the device.
SphereFollower::Next SphereFollower::fly(const Vec3& from, const Vec3& to, double& time) noexcept {
  ++flights_;
  const Vec3 device = on_path(from, to, time);
  double until = 1.0;
  const bool is_with_device = centre_ == device;
  const Next next = fly_to(is_with_device ? to : device, until);
  if (!is_with_device) return next == Next::settled && time < 1.0 ? Next::again : next;
  if (next != Next::settled) time = std::min(1.0, time + until * (1.0 - time));
  return next;
}

// Returns settled: arrived; again: hit a triangle; failed: also if too many triangles are near the way, as only a sweep can be interrupted.
SphereFollower::Next SphereFollower::fly_to(const Vec3& to, double& until) noexcept {
  constexpr int kFanInUnit = 4;  // triangles of a fan for each unit of work: they are neighbours in memory
  const Vec3 from = centre_;
  const Vec3 motion = to - from;
  std::uint32_t first = 0;
  double time = kNever;
  int tests = 0;
  int in_fan = 0;
  near_.geometry().visit_along(from, to, clearance().offset + clearance().tolerance, [&](std::uint32_t id, double before) {
    const bool is_in_fan = near_.geometry().is_in_large_fan(id);
    if (is_in_fan ? ++in_fan > NearTriangles::kMaxVisitedInFans : ++tests > kMaxFlightTests) return -1.0;
    work_ += is_in_fan ? in_fan % kFanInUnit == 0 : 1;
    const double t = time_to_block(TriangleView{near_.geometry(), id}, from, motion, std::min(before, time), clearance());
    if (!(t < time) || t > 1.0) return before;
    const ObjectGeometry::Corners corners = near_.geometry().corners(id);
    if (!near_.material(id).two_sided && !near_.can_touch(id, ContactTriangle(corners.a, corners.b, corners.c), from)) return before;
    first = id;
    time = t;
    return std::min(before, t);
  });
  has_given_up_flight_ = tests > kMaxFlightTests || in_fan > NearTriangles::kMaxVisitedInFans;
  if (has_given_up_flight_) return Next::failed;
  if (time > 1.0) {
    centre_ = to;
    friction_ = {};
    return Next::settled;
  }
  centre_ = from + time * motion;
  until = time;
  ++idle_events_;
  if (time * motion.norm() > LocalMinimum::kMinMotion) idle_events_ = 0;
  least_distance_ = std::numeric_limits<double>::infinity();
  const ObjectGeometry::Corners corners = near_.geometry().corners(first);
  const ContactTriangle shape(corners.a, corners.b, corners.c);
  if (overlaps(shape)) return Next::failed;
  direction_hint_ = motion;
  is_descending_ = true;
  return contacts_.add(OffsetContact::nearest(first, shape, centre_)) ? Next::again : Next::failed;
}

}  // namespace hapton
