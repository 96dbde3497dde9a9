// A sphere that crosses the faces of a convex or hollow fan: thousands of triangles that meet in one vertex, as at the tip of a cone.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/contact_qp.h"
#include "core/force/sphere/sphere_follower.h"
#include "core/math/exact_cross.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

using Part = OffsetContact::Part;

}  // namespace

// The corner of a face's triangle in which a fan meets that is convex or hollow as seen by the sphere; -1: the face is in none.
int SphereFollower::fan_corner(const OffsetContact& face) const noexcept {
  const int convex = near_.geometry().convex_fan_corner(face.triangle, face.back);
  return convex >= 0 ? convex : near_.geometry().convex_fan_corner(face.triangle, !face.back);
}

bool SphereFollower::is_hollow_fan(const OffsetContact& face) const noexcept {
  return near_.geometry().convex_fan_corner(face.triangle, face.back) < 0;
}

// Whether the centre may go some way without coming near anything but the fan that it is on. Holds in a ball around a centre, so it need
// not be found out in each step. Pre: the face is in a fan.
bool SphereFollower::is_alone_with_fan(const OffsetContact& face, const Vec3& towards) noexcept {
  constexpr double kLeastRoom = 0x1p-8;  // offsets
  constexpr int kPlanesInUnit = 4;
  constexpr int kSlotsInUnit = 16;
  const double least = kLeastRoom * clearance().offset;
  const int face_corner = fan_corner(face);
  const Vec3 tip = face.shape.corner(face_corner);
  const std::uint32_t mesh = near_.geometry().mesh_of(face.triangle);
  const std::uint32_t vertex = near_.geometry().corners(face.triangle).vertices[static_cast<std::size_t>(face_corner)];
  const bool is_known = fan_room_.mesh == mesh && fan_room_.vertex == vertex && fan_room_.back == face.back;
  if (is_known && (centre_ - fan_room_.at).norm() + least <= fan_room_.room) return true;
  const double near = clearance().offset + 2.0 * clearance().slop;
  const bool is_hollow = is_hollow_fan(face);
  const double enough = clearance().offset + 2.0 * towards.norm();
  if (near_.room_at(centre_) < near + (is_hollow ? enough : 2.0 * least)) {
    near_.widen(enough);  // hardly more triangles of the fan, for many steps
    if (!near_.gather(centre_, is_hollow ? Vec3::Zero() : towards, work_)) return false;
  }
  double room = near_.room_at(centre_) - near;
  int planes = 0;
  near_.visit_near(centre_, centre_, near + std::max(room, 0.0), [&](int slot) {
    const std::uint32_t triangle = near_.triangle(slot);
    const int corner = std::max(near_.geometry().convex_fan_corner(triangle, false), near_.geometry().convex_fan_corner(triangle, true));
    const bool is_in_fan = corner >= 0 && near_.geometry().mesh_of(triangle) == mesh &&
                           near_.geometry().corners(triangle).vertices[static_cast<std::size_t>(corner)] == vertex;
    if (!is_in_fan) {
      ++work_;
      room = std::min(room, near_.shape(slot).separation(centre_).distance - near);
    } else if (is_hollow) {
      const ObjectGeometry::Corners corners = near_.geometry().corners(triangle);
      const Vec3 normal = accurate_cross(corners.b - corners.a, corners.c - corners.a).normalized();
      fan_planes_[static_cast<std::size_t>(planes++)] = {face.back ? Vec3(-normal) : normal, triangle};
    }
  });
  work_ += planes / kPlanesInUnit + near_.count() / kSlotsInUnit;
  fan_room_ = {tip, centre_, room, mesh, vertex, face.back, planes};
  return room >= 2.0 * least;
}

// All contacts are with faces of the same fan, on one side. Pre: the first one is in a fan.
bool SphereFollower::touches_one_fan() const noexcept {
  const auto vertex_of = [&](const OffsetContact& face) {
    return near_.geometry().corners(face.triangle).vertices[static_cast<std::size_t>(fan_corner(face))];
  };
  const OffsetContact& first = contacts_[0];
  return std::all_of(contacts_.all().begin(), contacts_.all().end(), [&](const OffsetContact& other) {
    return other.part == Part::face && fan_corner(other) >= 0 && other.back == first.back &&
           near_.geometry().mesh_of(other.triangle) == near_.geometry().mesh_of(first.triangle) && vertex_of(other) == vertex_of(first);
  });
}

// The share of a straight motion that certainly stays in the room.
double SphereFollower::share_in_fan_room(const Vec3& c, const Vec3& motion) const noexcept {
  const double left = fan_room_.room - (c - fan_room_.at).norm();
  const double length = motion.norm();
  return left < length ? std::max(0.0, left / length) : 1.0;
}

// Follows the device over the faces of a convex or hollow fan. False: the sphere is on no fan, or gets no farther like that; its centre is
// valid for the device at `time`, and events go on from there.
bool SphereFollower::cross_fan(const Vec3& from, const Vec3& to, double& time) noexcept {
  if (is_point_ || fan_planes_.empty() || contacts_.is_empty() || contacts_[0].part != Part::face) return false;
  if (fan_corner(contacts_[0]) < 0) return false;
  const bool is_hollow = is_hollow_fan(contacts_[0]);
  // Before what has to look at all triangles around: a wall beside the fan is in contact, too.
  if (is_hollow ? !touches_one_fan() : contacts_.count() != 1) return false;
  if (!is_alone_with_fan(contacts_[0], to - from)) return false;
  if (!is_hollow) return cross_convex_fan(from, to, time);
  if (cross_hollow_fan(from, to, time)) return true;
  if (fan_room_.at == centre_) return false;
  fan_room_.room = -1.0;  // there may be more room around here
  return is_alone_with_fan(contacts_[0], to - from) && cross_hollow_fan(from, to, time);
}

// A convex fan touches the sphere with one face at a time. Where the device passes below an edge, the sphere rolls over that edge, however
// small the angle is, and goes on over the next face with the device held. Stops, at the latest, where the sphere leaves the fan or its
// room, or is released; events go on from there. False: that is here.
bool SphereFollower::cross_convex_fan(const Vec3& from, const Vec3& to, double& time) noexcept {
  constexpr int kFacesInUnit = 4;
  OffsetContact face = contacts_[0];
  const auto at_minimum = [&](const OffsetContact& over, const Vec3& device) {
    return Vec3(device + (clearance().offset - over.normal.dot(device - over.shape.corner(0))) * over.normal);
  };
  const Vec3 start = centre_;
  const double began = time;
  Vec3 c = centre_;
  bool settles = is_descending_;  // with the device held
  for (int n = 0; work_ <= most_work_; ++n) {
    work_ += n % kFacesInUnit == 0 ? 1 : 0;
    const double height = face.normal.dot(on_path(from, to, time) - face.shape.corner(0));
    const double height_then = face.normal.dot(to - face.shape.corner(0));
    if (!(height < clearance().offset)) break;
    double until = 1.0;
    if (height_then > clearance().offset) until = time + (1.0 - time) * (clearance().offset - height) / (height_then - height);
    Vec3 target = at_minimum(face, on_path(from, to, settles ? time : until));
    const double share = share_in_fan_room(c, target - c);
    if (share < 1.0) target = c + share * (target - c);
    const CentrePath path = CentrePath::straight(c, target);
    const FanExit exit = find_fan_exit(face, path);
    if (exit.edge < 0) {
      c = target;
      if (!settles) time += share * (until - time);
      if (!settles || share < 1.0) break;
      settles = false;
      continue;
    }
    until = time + share * (until - time);
    Vec3 next = path.at(exit.time);
    const double then = settles ? time : time + exit.time * (until - time);
    if (!cross_fan_edge(exit.edge, on_path(from, to, then), face, next)) break;
    c = next;
    time = then;
    settles = true;
  }
  centre_ = c;
  contacts_.hold_by({&face, 1});
  is_descending_ = settles;
  const bool has_moved = (centre_ - start).norm() > kLeastMotion;
  if (has_moved || (time - began) * (to - from).norm() > least_progress()) {
    note_gain(on_path(from, to, time), time > began);
    idle_ = 0;
    hint_ = centre_ - start;
    return true;
  }
  return false;
}

// Where a path over a face of a fan leaves it.
SphereFollower::FanExit SphereFollower::find_fan_exit(const OffsetContact& face, const CentrePath& path) const noexcept {
  FanExit exit;
  for (int k = 0; k < 3; ++k) {
    const Vec3 outwards = face.shape.edge(k).cross(face.shape.normal()) / face.shape.length(k);
    const double time = path.time_to_cross(face.shape.corner(k), outwards, PathEvents::kOnBoundary, 0.0, 1.0);
    if (time < exit.time) exit = {time, k};
  }
  return exit;
}

// Rolls over an edge to the next face of the fan. False, and nothing has changed: that face is in no such fan, or the device would hold the
// sphere on the edge, or it passes the tip.
bool SphereFollower::cross_fan_edge(int edge, const Vec3& device, OffsetContact& face, Vec3& c) const noexcept {
  const int corner = fan_corner(face);
  const TouchGeometry::Adjacent across = near_.geometry().adjacent(face.triangle, edge);
  if (edge == (corner + 1) % 3 || !across.exists || across.flips) return false;
  const ObjectGeometry::Corners corners = near_.geometry().corners(across.id);
  const ContactTriangle shape(corners.a, corners.b, corners.c);
  const OffsetContact beyond = OffsetContact::on_face(across.id, shape, face.back ? Vec3(-shape.normal()) : shape.normal());
  const int corner_there = near_.geometry().convex_fan_corner(beyond.triangle, beyond.back);
  if (corner_there < 0 || shape.corner(corner_there) != face.shape.corner(corner)) return false;
  const Vec3 closest = c - clearance().offset * face.normal;
  const Vec3 inwards = shape.normal().cross(shape.edge(across.edge));
  if (!(inwards.dot(device - closest) > 0.0)) return false;
  for (int k = 0; k < 3; ++k) {
    if (k != across.edge && !(shape.inside(k, closest) > 0.0)) return false;
  }
  Vec3 there = closest + clearance().offset * beyond.normal;
  there += (clearance().offset - beyond.proximity(there).distance) * beyond.normal;
  const double rolled = (there - c).norm();
  if ((there - fan_room_.at).norm() + rolled > fan_room_.room) return false;
  face = beyond;
  c = there;
  return true;
}

// In a hollow fan the centres that the planes allow are a convex set, of which the sphere is the point nearest to the device, whatever its
// way was. So it goes there at once, as long as it stays in contact with faces of the fan, in its room. The nearest point moves no farther
// than the device: where the room ends first, a part of the motion is certainly in it, or, with the device held, the point nearest to a
// place on the way to the device.
bool SphereFollower::cross_hollow_fan(const Vec3& from, const Vec3& to, double& time) noexcept {
  const Vec3 device = on_path(from, to, time);
  const Vec3 rest = to - device;
  HollowPlace place;
  // The device may be free on its way, so that only all of it tells where the sphere gets.
  const bool has_room = share_in_fan_room(centre_, rest) >= 1.0 &&
                        (!is_descending_ || rest.isZero(0.0) || share_in_fan_room(centre_, device - centre_) >= 1.0);
  if (has_room && find_in_hollow_fan(to, place)) {
    move_in_hollow_fan(place, to, 1.0, false, time);
  } else if (is_descending_) {
    const double share = share_in_fan_room(centre_, device - centre_);
    if (!find_in_hollow_fan(centre_ + share * (device - centre_), place)) return false;
    move_in_hollow_fan(place, device, time, share < 1.0, time);
  } else {
    const double share = share_in_fan_room(centre_, rest);
    const double then = time + share * (1.0 - time);
    if (!(share > 0.0) || share >= 1.0 || !find_in_hollow_fan(on_path(from, to, then), place)) return false;
    move_in_hollow_fan(place, on_path(from, to, then), then, false, time);
  }
  return true;
}

void SphereFollower::move_in_hollow_fan(const HollowPlace& place, const Vec3& device, double then, bool descends, double& time) noexcept {
  const bool has_moved = then > time || (place.centre - centre_).norm() > kLeastMotion;
  hint_ = place.centre - centre_;
  centre_ = place.centre;
  contacts_.hold_by({place.contacts.data(), static_cast<std::size_t>(place.count)});
  is_descending_ = descends;
  has_lost_minimum_ = false;
  time = then;
  if (has_moved) idle_ = 0;
  note_gain(device, has_moved);
}

// The constrained minimum over all planes: the one that is violated most joins those that are active, until none is.
bool SphereFollower::find_in_hollow_fan(const Vec3& device, HollowPlace& place) noexcept {
  constexpr int kMostRounds = 32;
  std::array<ContactPlane, 4> planes;
  std::array<int, 4> of{};
  std::size_t count = 0;
  ConstrainedMotion held;
  const Vec3 goal = device - centre_;
  held.motion = goal;
  const auto height_of = [&](int plane, const Vec3& c) {
    return fan_planes_[static_cast<std::size_t>(plane)].normal.dot(c - fan_room_.tip) - clearance().offset;
  };
  bool is_found = false;
  for (int round = 0; round < kMostRounds && !is_found; ++round) {
    double height = 0.0;
    const int lowest = find_lowest_plane(centre_ + held.motion, height);
    is_found = height >= -0.25 * clearance().slop;
    if (is_found) break;
    std::array<int, 4> next{};
    std::size_t kept = 0;
    for (int i = 0; i < held.active_count; ++i) next[kept++] = of[static_cast<std::size_t>(held.active[static_cast<std::size_t>(i)])];
    if (std::count(next.begin(), next.begin() + kept, lowest) > 0) return false;
    next[kept] = lowest;
    count = kept + 1;
    of = next;
    for (std::size_t i = 0; i < count; ++i) planes[i] = {fan_planes_[static_cast<std::size_t>(of[i])].normal, -height_of(of[i], centre_)};
    held = constrain_motion(goal, std::span<const ContactPlane>(planes.data(), count));
    if (!held.solved) return false;
  }
  if (!is_found || held.active_count == 0) return false;
  place.centre = centre_ + held.motion;
  place.count = held.active_count;
  if ((place.centre - fan_room_.at).norm() > fan_room_.room) return false;
  for (int i = 0; i < held.active_count; ++i) {
    const FanPlane& plane = fan_planes_[static_cast<std::size_t>(of[static_cast<std::size_t>(held.active[static_cast<std::size_t>(i)])])];
    const ObjectGeometry::Corners corners = near_.geometry().corners(plane.triangle);
    const ContactTriangle shape(corners.a, corners.b, corners.c);
    const Vec3 closest = place.centre - clearance().offset * plane.normal;
    for (int k = 0; k < 3; ++k) {
      if (!(shape.inside(k, closest) > 0.0)) return false;
    }
    place.contacts[static_cast<std::size_t>(i)] = OffsetContact::on_face(plane.triangle, shape, plane.normal);
  }
  return true;
}

// The plane that a centre is least above, and its height there above the position in contact.
int SphereFollower::find_lowest_plane(const Vec3& c, double& height) noexcept {
  constexpr int kPlanesInUnit = 64;
  const Vec3 off = c - fan_room_.tip;
  int lowest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < fan_room_.planes; ++i) {
    const double at = fan_planes_[static_cast<std::size_t>(i)].normal.dot(off);
    if (at < least) lowest = i;
    least = std::min(least, at);
  }
  height = least - clearance().offset;
  work_ += 1 + fan_room_.planes / kPlanesInUnit;
  return lowest;
}

}  // namespace hapton
