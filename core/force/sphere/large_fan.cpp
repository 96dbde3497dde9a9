#include "core/force/sphere/large_fan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/contact_qp.h"
#include "core/force/sphere/path_events.h"
#include "core/math/exact_cross.h"
#include "core/math/straight_motion.h"

namespace hapton {

// The corner of a face's triangle that is the tip of a large fan, convex or hollow as seen by the sphere; -1: there is no such fan.
int LargeFan::fan_corner(const OffsetContact& face) const noexcept {
  const int convex = geometry_.convex_fan_corner(face.triangle, face.back);
  return convex >= 0 ? convex : geometry_.convex_fan_corner(face.triangle, !face.back);
}

bool LargeFan::is_hollow_fan(const OffsetContact& face) const noexcept { return geometry_.convex_fan_corner(face.triangle, face.back) < 0; }

// Whether the centre can move some way before the sphere comes near anything but the fan that it touches. The result holds in a ball around
// the centre (room_), and is kept for later steps. Pre: the face is in a fan.
bool LargeFan::is_alone_with_fan(SphereOnFan& on, const OffsetContact& face, const Vec3& towards) noexcept {
  constexpr double kMinRoom = 0x1p-8;  // offsets
  constexpr int kPlanesInUnit = 4;     // this and the next: how many of them cost one unit of work (step_work.h)
  constexpr int kSlotsInUnit = 16;
  const double least = kMinRoom * on.contacts.offset();
  const int face_corner = fan_corner(face);
  const Vec3 tip = face.shape.corner(face_corner);
  const std::uint32_t mesh = geometry_.mesh_of(face.triangle);
  const std::uint32_t vertex = geometry_.corners(face.triangle).vertices[face_corner];
  const bool is_known = room_.mesh == mesh && room_.vertex == vertex && room_.back == face.back;
  if (is_known && (on.centre - room_.at).norm() + least <= room_.room) return true;
  const double near = on.contacts.offset() + 2.0 * on.contacts.clearance().slop;
  const bool is_hollow = is_hollow_fan(face);
  const double enough = on.contacts.offset() + 2.0 * towards.norm();
  if (on.near.covered_radius_at(on.centre) < near + (is_hollow ? enough : 2.0 * least)) {
    on.near.widen(enough);  // a wider ball holds hardly more triangles of the fan, and serves many steps
    if (!on.near.gather(on.centre, is_hollow ? Vec3::Zero() : towards, on.work)) return false;
  }
  double room = on.near.covered_radius_at(on.centre) - near;
  int planes = 0;
  on.near.visit_near(on.centre, on.centre, near + std::max(room, 0.0), [&](int slot) {
    const std::uint32_t triangle = on.near.triangle(slot);
    const int corner = std::max(geometry_.convex_fan_corner(triangle, false), geometry_.convex_fan_corner(triangle, true));
    const bool is_in_fan = corner >= 0 && geometry_.mesh_of(triangle) == mesh && geometry_.corners(triangle).vertices[corner] == vertex;
    if (!is_in_fan) {
      ++on.work;
      room = std::min(room, on.near.shape(slot).separation(on.centre).distance - near);
    } else if (is_hollow) {
      const ObjectGeometry::Corners corners = geometry_.corners(triangle);
      const Vec3 normal = accurate_cross(corners.b - corners.a, corners.c - corners.a).normalized();
      planes_[planes++] = {face.back ? Vec3(-normal) : normal, triangle};
    }
  });
  on.work += planes / kPlanesInUnit + on.near.count() / kSlotsInUnit;
  room_ = {tip, on.centre, room, mesh, vertex, face.back, planes};
  return room >= 2.0 * least;
}

// Whether all contacts are with faces of the same fan, on the same side. Pre: the first one is with a face in a fan.
bool LargeFan::touches_one_fan(const SphereOnFan& on) const noexcept {
  const auto vertex_of = [&](const OffsetContact& face) { return geometry_.corners(face.triangle).vertices[fan_corner(face)]; };
  const OffsetContact& first = on.contacts[0];
  return std::ranges::all_of(on.contacts.all(), [&](const OffsetContact& other) {
    return other.part == Feature::face && fan_corner(other) >= 0 && other.back == first.back &&
           geometry_.mesh_of(other.triangle) == geometry_.mesh_of(first.triangle) && vertex_of(other) == vertex_of(first);
  });
}

// The share of a straight motion that certainly stays within room_.
double LargeFan::share_in_fan_room(const Vec3& c, const Vec3& motion) const noexcept {
  const double remaining_room = room_.room - (c - room_.at).norm();
  const double length = motion.norm();
  return remaining_room < length ? std::max(0.0, remaining_room / length) : 1.0;
}

LargeFan::Crossing LargeFan::cross(SphereOnFan on, const Vec3& from, const Vec3& to, double& time) noexcept {
  if (planes_.empty() || on.contacts.is_empty() || on.contacts[0].part != Feature::face) return Crossing::none;
  if (fan_corner(on.contacts[0]) < 0) return Crossing::none;
  const bool is_hollow = is_hollow_fan(on.contacts[0]);
  // Tested first, because is_alone_with_fan() looks at all triangles nearby: a wall beside the fan may be in contact, too.
  if (is_hollow ? !touches_one_fan(on) : on.contacts.count() != 1) return Crossing::none;
  if (!is_alone_with_fan(on, on.contacts[0], to - from)) return Crossing::none;
  if (!is_hollow) return cross_convex_fan(on, from, to, time) ? Crossing::convex : Crossing::none;
  if (cross_hollow_fan(on, from, to, time)) return Crossing::hollow;
  if (room_.at == on.centre) return Crossing::none;
  room_.room = -1.0;  // finds the room anew below: there may be more of it around this centre
  return is_alone_with_fan(on, on.contacts[0], to - from) && cross_hollow_fan(on, from, to, time) ? Crossing::hollow : Crossing::none;
}

// A convex fan touches the sphere with one face at a time. Where the device passes below an edge, the sphere rolls over that edge, however
// small its angle is, and continues over the next face with the device held. Stops at the latest where the sphere leaves the fan or its
// room, or is released; the follower then continues with events. False: neither the centre nor the time has advanced.
bool LargeFan::cross_convex_fan(SphereOnFan& on, const Vec3& from, const Vec3& to, double& time) noexcept {
  constexpr int kFacesInUnit = 4;  // faces that cost one unit of work (step_work.h)
  OffsetContact face = on.contacts[0];
  const auto at_minimum = [&](const OffsetContact& over, const Vec3& device) {
    return Vec3(device + (on.contacts.offset() - over.normal.dot(device - over.shape.corner(0))) * over.normal);
  };
  const Vec3 start = on.centre;
  const double start_time = time;
  Vec3 c = on.centre;
  bool settles = on.is_descending;  // whether the centre moves with the device held
  for (int n = 0; on.work <= on.most_work; ++n) {
    on.work += n % kFacesInUnit == 0 ? 1 : 0;
    const double height = face.normal.dot(on_path(from, to, time) - face.shape.corner(0));
    const double height_then = face.normal.dot(to - face.shape.corner(0));
    if (!(height < on.contacts.offset())) break;
    double until = 1.0;
    if (height_then > on.contacts.offset()) until = time + (1.0 - time) * (on.contacts.offset() - height) / (height_then - height);
    Vec3 target = at_minimum(face, on_path(from, to, settles ? time : until));
    const double share = share_in_fan_room(c, target - c);
    if (share < 1.0) target = c + share * (target - c);
    const CentrePath path = CentrePath::straight(c, target);
    PathEvents::Exit exit;
    const double leave_time = PathEvents::time_off_face(path, face.shape, 0.0, 1.0, exit);
    if (leave_time >= kNever) {
      c = target;
      if (!settles) time += share * (until - time);
      if (!settles || share < 1.0) break;
      settles = false;
      continue;
    }
    until = time + share * (until - time);
    Vec3 next = path.at(leave_time);
    const double then = settles ? time : time + leave_time * (until - time);
    if (!cross_fan_edge(on, exit.index, on_path(from, to, then), face, next)) break;
    c = next;
    time = then;
    settles = true;
  }
  on.centre = c;
  on.contacts.hold_by({&face, 1});
  on.is_descending = settles;
  const bool has_moved = (on.centre - start).norm() > LocalMinimum::kMinMotion;
  return has_moved || (time - start_time) * (to - from).norm() > LocalMinimum::kMinMotion;
}

// Rolls over an edge to the next face of the fan. False, with nothing changed: that face is not in the same convex fan, the device would
// hold the sphere on the edge, or the sphere would pass the tip or leave its room.
bool LargeFan::cross_fan_edge(const SphereOnFan& on, int edge, const Vec3& device, OffsetContact& face, Vec3& c) const noexcept {
  const int corner = fan_corner(face);
  const TouchGeometry::Adjacent across = geometry_.adjacent(face.triangle, edge);
  if (edge == (corner + 1) % 3 || !across.exists || across.flips) return false;
  const ObjectGeometry::Corners corners = geometry_.corners(across.id);
  const ContactTriangle shape(corners.a, corners.b, corners.c);
  const OffsetContact beyond = OffsetContact::on_face(across.id, shape, face.back ? Vec3(-shape.normal()) : shape.normal());
  const int corner_there = geometry_.convex_fan_corner(beyond.triangle, beyond.back);
  if (corner_there < 0 || shape.corner(corner_there) != face.shape.corner(corner)) return false;
  const Vec3 closest = c - on.contacts.offset() * face.normal;
  const Vec3 inwards = shape.normal().cross(shape.edge(across.edge));
  if (!(inwards.dot(device - closest) > 0.0)) return false;
  for (int k = 0; k < 3; ++k) {
    if (k != across.edge && !(shape.inside(k, closest) > 0.0)) return false;
  }
  Vec3 there = closest + on.contacts.offset() * beyond.normal;
  there += (on.contacts.offset() - beyond.proximity(there).distance) * beyond.normal;
  const double rolled = (there - c).norm();
  if ((there - room_.at).norm() + rolled > room_.room) return false;
  face = beyond;
  c = there;
  return true;
}

// In a hollow fan, the centres that the planes allow are a convex set. The sphere's centre is the point of this set nearest to the device,
// whatever path led there. So it moves there at once, if it stays in contact with faces of the fan, within the room. The nearest point
// moves no farther than the device. So if the room ends first, the centre follows a part of the device's motion that stays in the room or,
// with the device held, moves to the point nearest to a place on the way to the device.
bool LargeFan::cross_hollow_fan(SphereOnFan& on, const Vec3& from, const Vec3& to, double& time) noexcept {
  const Vec3 device = on_path(from, to, time);
  const Vec3 remaining_motion = to - device;
  HollowPlace place;
  // The sphere may come free on the way, so only the whole motion of the device tells where the sphere ends.
  const bool has_room = share_in_fan_room(on.centre, remaining_motion) >= 1.0 &&
                        (!on.is_descending || remaining_motion.isZero(0.0) || share_in_fan_room(on.centre, device - on.centre) >= 1.0);
  if (has_room && find_in_hollow_fan(on, to, place)) {
    move_in_hollow_fan(on, place, false);
    time = 1.0;
  } else if (on.is_descending) {
    const double share = share_in_fan_room(on.centre, device - on.centre);
    if (!find_in_hollow_fan(on, on.centre + share * (device - on.centre), place)) return false;
    move_in_hollow_fan(on, place, share < 1.0);
  } else {
    const double share = share_in_fan_room(on.centre, remaining_motion);
    const double then = time + share * (1.0 - time);
    if (!(share > 0.0) || share >= 1.0 || !find_in_hollow_fan(on, on_path(from, to, then), place)) return false;
    move_in_hollow_fan(on, place, false);
    time = then;
  }
  return true;
}

void LargeFan::move_in_hollow_fan(SphereOnFan& on, const HollowPlace& place, bool descends) noexcept {
  on.centre = place.centre;
  on.contacts.hold_by(std::span(place.contacts).first(place.count));
  on.is_descending = descends;
}

// Finds the constrained minimum over all planes: adds the plane that is violated most to the active ones, until none is violated.
bool LargeFan::find_in_hollow_fan(SphereOnFan& on, const Vec3& device, HollowPlace& place) noexcept {
  constexpr int kMaxRounds = 32;  // a bound on the work; after these, the follower continues with events
  std::array<ContactPlane, 4> planes;
  std::array<int, 4> plane_indices{};
  ConstrainedMotion constrained;
  const Vec3 goal = device - on.centre;
  constrained.motion = goal;
  const auto height_of = [&](int plane, const Vec3& c) { return planes_[plane].normal.dot(c - room_.tip) - on.contacts.offset(); };
  for (int round = 0;; ++round) {
    if (round == kMaxRounds) return false;
    double height = 0.0;
    const int lowest = find_lowest_plane(on, on.centre + constrained.motion, height);
    if (height >= -0.25 * on.contacts.clearance().slop) break;
    std::array<int, 4> next_indices{};
    int count = 0;
    for (int i = 0; i < constrained.active_count; ++i) next_indices[count++] = plane_indices[constrained.active[i]];
    if (std::count(next_indices.begin(), next_indices.begin() + count, lowest) > 0) return false;
    next_indices[count++] = lowest;
    plane_indices = next_indices;
    for (int i = 0; i < count; ++i) planes[i] = {planes_[plane_indices[i]].normal, -height_of(plane_indices[i], on.centre)};
    constrained = constrain_motion(goal, std::span(planes).first(count));
    if (!constrained.solved) return false;
  }
  if (constrained.active_count == 0) return false;
  place.centre = on.centre + constrained.motion;
  place.count = constrained.active_count;
  if ((place.centre - room_.at).norm() > room_.room) return false;
  for (int i = 0; i < constrained.active_count; ++i) {
    const FanPlane& plane = planes_[plane_indices[constrained.active[i]]];
    const ObjectGeometry::Corners corners = geometry_.corners(plane.triangle);
    const ContactTriangle shape(corners.a, corners.b, corners.c);
    const Vec3 closest = place.centre - on.contacts.offset() * plane.normal;
    for (int k = 0; k < 3; ++k) {
      if (!(shape.inside(k, closest) > 0.0)) return false;
    }
    place.contacts[i] = OffsetContact::on_face(plane.triangle, shape, plane.normal);
  }
  return true;
}

// Returns the plane over which the centre c is lowest. `height`: its height over that plane, less the height in contact.
int LargeFan::find_lowest_plane(SphereOnFan& on, const Vec3& c, double& height) noexcept {
  constexpr int kPlanesInUnit = 64;  // planes that cost one unit of work (step_work.h)
  const Vec3 off = c - room_.tip;
  int lowest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < room_.planes; ++i) {
    const double at = planes_[i].normal.dot(off);
    if (at < least) lowest = i;
    least = std::min(least, at);
  }
  height = least - on.contacts.offset();
  on.work += 1 + room_.planes / kPlanesInUnit;
  return lowest;
}

}  // namespace hapton
