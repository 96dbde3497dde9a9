// The first event on a piece of a sphere's path, and the contacts after it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/sphere/sphere_follower.h"

namespace hapton {
namespace {

using Part = OffsetContact::Part;

// Whether a triangle at an edge of the face lies beyond that edge. At the edge of a blade it is folded back under the face.
bool lies_beyond(const ContactTriangle& face, int edge, const ContactTriangle& other) {
  for (int k = 0; k < 3; ++k) {
    const Vec3& corner = other.corner(k);
    const bool is_end = corner == face.corner(edge) || corner == face.corner((edge + 1) % 3);
    if (!is_end && face.inside(edge, corner) < 0.0) return true;
  }
  return false;
}

// Calls visit(direction, edge) for the edges of a triangle that end at a vertex: unit, from there.
template <class Visit>
void visit_edges_at(const Vec3& vertex, const ObjectGeometry::Corners& corners, Visit&& visit) {
  const std::array<const Vec3*, 3> corner = {&corners.a, &corners.b, &corners.c};
  for (int k = 0; k < 3; ++k) {
    const Vec3& first = *corner[static_cast<std::size_t>(k)];
    const Vec3& last = *corner[static_cast<std::size_t>((k + 1) % 3)];
    if (first != vertex && last != vertex) continue;
    const Vec3 edge = last - first;
    const double length = std::sqrt(edge.squaredNorm());
    if (length > 0.0) visit(Vec3(edge * ((first == vertex ? 1.0 : -1.0) / length)), k);
  }
}

}  // namespace

// The first event on the path, up to the time in `event`. False: it cannot be computed.
bool SphereFollower::find_event(const CentrePath& path, Event& event) noexcept {
  // A path over a face leaves it long before its end; only the other parts have boundaries that depend on the triangles nearby.
  const bool is_curved =
      std::any_of(contacts_.active().begin(), contacts_.active().end(), [](const OffsetContact& c) { return c.is_curved(); });
  if (is_curved && !near_.cover(path, event.time, work_)) return false;
  const double near = clearance().offset + path.bulge() + clearance().slop;
  CentrePath::Prefix prefix = path.prefix(event.time);
  if (is_curved) {
    if (!find_candidates(path, near, prefix)) return false;
    event.time = prefix.until;
  }
  for (int i = 0; i < contacts_.active_count(); ++i) {
    LevelFaces& crossed = crossed_[static_cast<std::size_t>(i)];
    crossed.until = 0.0;
    Event exit = event;
    find_first_exit(path, i, prefix, exit);
    if (exit.contact != i) continue;
    if (contacts_[i].part == Part::face) {
      crossed.first = crossed.last = contacts_[i];
      if (!cross_level_faces(path, event.time, crossed.last, exit)) exit = event;
      crossed.until = exit.time;
      prefix = path.prefix(exit.time);
    }
    event = exit;
  }
  if (!is_curved) {
    const double exit_time = event.time;
    if (!near_.cover(path, event.time, work_)) return false;
    if (event.time < exit_time) prefix = path.prefix(event.time);
    if (!find_candidates(path, near, prefix)) return false;
    event.time = prefix.until;
    if (event.time < exit_time) event.contact = -1;
  }
  const bool is_on_plane =
      (path.is_straight() || contacts_.active_count() == 1) && contacts_.active_count() > 0 && contacts_[0].part == Part::face;
  tangent_count_ = -1;
  for (int i = 0; i < candidate_count_; ++i) {
    const int slot = candidates_[static_cast<std::size_t>(i)];
    if (near_.distance_bound(slot, path.start()) > near && near_.distance_bound(slot, prefix.end) > near) continue;
    if (cannot_stop(slot, path.start(), is_on_plane)) continue;
    const ContactTriangle& shape = near_.shape(slot);
    if (tangent_count_ < 0) note_tangents(path);
    if (is_below_tangents(shape)) continue;
    const CentrePath::Block block =
        path.find_block(shape, clearance(), path.is_straight() ? 0U : contacts_.guiding_corners(shape), prefix, work_);
    if (!(block.time < event.time)) continue;
    event.time = block.time;
    event.contact = -1;
    event.slot = block.hits ? slot : -1;
    prefix = path.prefix(event.time);
  }
  move_to_last_level_face(path, event);
  return true;
}

// The first time at which a contact leaves its part, up to that of the event.
void SphereFollower::find_first_exit(const CentrePath& path, int contact, CentrePath::Prefix& prefix, Event& event) noexcept {
  visit_exits(contacts_[contact], [&](const Exit& exit) {
    const double time = path.time_to_cross(exit.origin, exit.direction, kOnBoundary, prefix);
    if (time > event.time || (time == event.time && event.contact >= 0)) return;
    const bool is_face_here = time <= 0.0 && exit.slot >= 0 && exit.part == Part::face;
    if (is_face_here && is_past_needle(near_.shape(exit.slot), exit.index)) return;
    event.time = time;
    event.contact = contact;
    event.exit = exit;
    prefix = path.prefix(time);
  });
}

// Over an edge where the next face lies in the same plane nothing changes but the triangle. Follows the path over such faces, from the exit
// in `event`, until it leaves them (true; `event` has that exit and `contact` the face before it) or until that time.
bool SphereFollower::cross_level_faces(const CentrePath& path, double until, OffsetContact& contact, Event& event) const noexcept {
  constexpr int kMostFaces = 1024;
  for (int n = 0; n < kMostFaces; ++n) {
    work_ += path.is_straight() ? n % 2 : 2;
    OffsetContact level;
    const double here = event.time;
    if (!find_level_face(contact, event.exit.index, path.at(here), level)) return true;
    Exit exit;
    double then = kNever;
    for (int k = 0; k < 3; ++k) {
      const Vec3& origin = level.shape.corner(k);
      const Vec3 direction = level.shape.edge(k).cross(level.shape.normal()) / level.shape.length(k);
      const double time = path.time_to_cross(origin, direction, kOnBoundary, here, until);
      if (!(time < then)) continue;
      then = time;
      exit = {origin, direction, -1, k, Part::edge};
    }
    const bool leaves = then <= until;
    if (!is_level_at(level, path.at(leaves ? then : until))) return true;
    contact = level;
    if (!leaves) return false;
    event.time = then;
    event.exit = exit;
  }
  return true;
}

// The face beyond an edge, if its plane is the same within rounding where the centre at c crosses over to it. The normals of two needles in
// one plane differ by the rounding of their corners, as a share of their heights: 2^-51 over 2^-15 at the most. A force turns by less.
bool SphereFollower::find_level_face(const OffsetContact& contact, int edge, const Vec3& c, OffsetContact& level) const noexcept {
  constexpr double kMostTilt = 0x1p-36;  // rad
  const TouchGeometry::Adjacent across = near_.geometry().adjacent(contact.triangle, edge);
  if (!across.exists || across.id == contact.triangle) return false;
  const ObjectGeometry::Corners corners = near_.geometry().corners(across.id);
  const ContactTriangle shape(corners.a, corners.b, corners.c);
  if (!(shape.normal().cross(contact.normal).squaredNorm() <= kMostTilt * kMostTilt) || !is_over(shape, c)) return false;
  if (!near_.can_touch(across.id, shape, c)) return false;
  level = OffsetContact::on_face(across.id, shape, contact.normal);
  return is_level_at(level, c);
}

// Whether the centre at c is in contact with a face within rounding.
bool SphereFollower::is_level_at(const OffsetContact& face, const Vec3& c) const noexcept {
  return std::fabs(face.proximity(c).distance - clearance().offset) <= kCoplanar;
}

bool SphereFollower::is_over(const ContactTriangle& shape, const Vec3& c) noexcept {
  return shape.inside(0, c) > 0.0 && shape.inside(1, c) > 0.0 && shape.inside(2, c) > 0.0;
}

// The contacts that cross level faces on the way are on the last of these before the event.
void SphereFollower::move_to_last_level_face(const CentrePath& path, const Event& event) noexcept {
  for (int i = 0; i < contacts_.active_count(); ++i) {
    LevelFaces& crossed = crossed_[static_cast<std::size_t>(i)];
    if (!(crossed.until > 0.0)) continue;
    if (event.time < crossed.until) {
      Event exit;
      exit.time = event.time;
      CentrePath::Prefix prefix = path.prefix(event.time);
      find_first_exit(path, i, prefix, exit);
      if (exit.contact != i) continue;
      crossed.last = contacts_[i];
      cross_level_faces(path, event.time, crossed.last, exit);
    }
    contacts_[i] = crossed.last;
  }
}

// Whether a triangle cannot stop the centre, whatever its distance. Triangles below the plane of a face are never nearer than the face, for
// a centre that moves over it.
bool SphereFollower::cannot_stop(int slot, const Vec3& from, bool is_on_plane) noexcept {
  const std::uint32_t triangle = near_.triangle(slot);
  const ObjectGeometry::Corners corners = near_.geometry().corners(triangle);
  if (is_on_plane) {
    const Vec3& up = contacts_[0].normal;
    const double level = up.dot(from) - clearance().offset + 0.25 * clearance().slop;
    if (std::max({up.dot(corners.a), up.dot(corners.b), up.dot(corners.c)}) <= level) return true;
  }
  if (contacts_.holds_part_of(corners, triangle)) return true;
  return !near_.material(triangle).two_sided && !near_.can_touch(triangle, near_.shape(slot), from);
}

// Over a face both planes are its own. Over an edge the plane turns about it, to one side only where the path does not turn back: that is
// checked for the cubic, with room for what the curve differs.
void SphereFollower::note_tangents(const CentrePath& path) noexcept {
  constexpr double kLeastPace = 0.25;
  constexpr double kMostPace = 2.5;
  tangent_count_ = 0;
  if (!path.is_guided() && !path.is_straight()) return;
  for (int i = 0; i < contacts_.active_count(); ++i) {
    const OffsetContact& contact = contacts_[i];
    TangentSpan& span = tangents_[static_cast<std::size_t>(tangent_count_)];
    if (contact.part == Part::face) {
      span = {contact.shape.corner(0), {contact.normal, contact.normal}};
      ++tangent_count_;
    } else if (contact.part == Part::edge && path.is_guided()) {
      span = {contact.origin(), {contact.proximity(path.start()).normal, contact.proximity(path.end()).normal}};
      const Vec3 turn = clearance().offset * (span.normal[1] - span.normal[0]);
      const double whole = turn.squaredNorm();
      const double first = turn.dot(path.slope(0.0));
      const double last = turn.dot(path.slope(1.0));
      if (std::min(first, last) >= kLeastPace * whole && std::max(first, last) <= kMostPace * whole) ++tangent_count_;
    }
  }
}

// Such a triangle is below the tangent plane in each place of the path, and never nearer than the contact.
bool SphereFollower::is_below_tangents(const ContactTriangle& shape) const noexcept {
  const double level = 0.25 * clearance().slop;
  for (int i = 0; i < tangent_count_; ++i) {
    const TangentSpan& span = tangents_[static_cast<std::size_t>(i)];
    double highest = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Vec3 off = shape.corner(k) - span.origin;
      highest = std::max({highest, span.normal[0].dot(off), span.normal[1].dot(off)});
    }
    if (highest <= level) return true;
  }
  return false;
}

// Collects the triangles that may come that near to the beginning of the path. Where they are many because the ball of gathered triangles
// lies elsewhere, it is gathered again around the start. False: that cannot be done.
bool SphereFollower::find_candidates(const CentrePath& path, double near, CentrePath::Prefix& prefix) noexcept {
  constexpr int kMany = 32;
  note_candidates(path.start(), prefix.end, near);
  if (candidate_count_ <= kMany || near_.is_central(path.start())) return true;
  double until = prefix.until;
  if (!near_.gather(centre_, Vec3::Zero(), work_) || !near_.cover(path, until, work_)) return false;
  if (until < prefix.until) prefix = path.prefix(until);
  note_candidates(path.start(), prefix.end, near);
  return true;
}

// Collects the triangles that may come that near to the segment.
void SphereFollower::note_candidates(const Vec3& from, const Vec3& to, double near) noexcept {
  candidate_count_ = 0;
  near_.visit_near(from, to, near, [&](int slot) { candidates_[static_cast<std::size_t>(candidate_count_++)] = slot; });
}

// Calls visit(exit) for the boundaries of the part that a contact is on. Pre: for an edge or a vertex, note_candidates().
template <class Visit>
void SphereFollower::visit_exits(const OffsetContact& contact, Visit&& visit) noexcept {
  const ContactTriangle& own = contact.shape;
  if (contact.part == Part::face) {
    for (int k = 0; k < 3; ++k) visit(Exit{own.corner(k), own.edge(k).cross(own.normal()) / own.length(k), -1, k, Part::edge});
    return;
  }
  if (contact.part == Part::edge) {
    const Vec3 axis = contact.axis();
    visit(Exit{own.corner((contact.index + 1) % 3), axis, -1, (contact.index + 1) % 3, Part::vertex});
    visit(Exit{own.corner(contact.index), -axis, -1, contact.index, Part::vertex});
  }
  for (int i = 0; i < candidate_count_; ++i) {
    const int slot = candidates_[static_cast<std::size_t>(i)];
    const ObjectGeometry::Corners corners = near_.geometry().corners(near_.triangle(slot));
    if (!contact.is_shared_with(corners.a, corners.b, corners.c)) continue;
    if (contact.part == Part::vertex) {
      visit_edges_at(contact.origin(), corners, [&](const Vec3& outwards, int k) {
        visit(Exit{contact.origin(), outwards, slot, k, Part::edge});
      });
      continue;
    }
    const ContactTriangle& shape = near_.shape(slot);
    const Vec3& other = own.corner((contact.index + 1) % 3);
    for (int k = 0; k < 3; ++k) {
      const Vec3& first = shape.corner(k);
      const Vec3& last = shape.corner((k + 1) % 3);
      if (!(shape.length(k) > 0.0) || shape.normal().isZero(0.0)) continue;
      if (!(first == contact.origin() && last == other) && !(last == contact.origin() && first == other)) continue;
      visit(Exit{first, shape.normal().cross(shape.edge(k)) / shape.length(k), slot, k, Part::face});
    }
  }
}

// Whether the centre, in contact with that edge of a triangle, is far over its plane but not over the triangle. This is so at a needle that
// rises by less than the slop, so that it was not hit: its face never holds the sphere.
bool SphereFollower::is_past_needle(const ContactTriangle& shape, int edge) const noexcept {
  const auto height = [&](int k) { return shape.inside(k, centre_) / shape.length(k); };
  return height(edge) > kSlop && std::min(height((edge + 1) % 3), height((edge + 2) % 3)) < -kSlop;
}

// Whether the centre is nearer to a triangle than any centre in contact.
bool SphereFollower::overlaps(const ContactTriangle& shape) const noexcept {
  return shape.separation(centre_).distance < clearance().offset - std::min(0x1p-28, 0.25 * clearance().offset);
}

// Changes the contacts for the event. False: it cannot.
bool SphereFollower::apply_event(const Event& event, const CentrePath& path) noexcept {
  if (event.contact >= 0) {
    is_descending_ = true;
    const bool is_coplanar = idle_ > kMostIdle / 4;  // treating it as rising made no progress: within rounding the faces are coplanar
    const int rising = event.exit.part == Part::edge && !is_coplanar
                           ? find_rising(contacts_[event.contact], event.exit.index, path.slope(event.time))
                           : -1;
    if (rising >= 0)
      return contacts_.add(OffsetContact::on_face(near_.triangle(rising), near_.shape(rising), contacts_[event.contact].normal));
    if (const int level = event.exit.part == Part::edge ? find_coplanar(contacts_[event.contact], event.exit) : -1; level >= 0) {
      hint_ = path.slope(event.time);
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
    // No position fits it and the others. The others are hit again if they are in the way.
    contacts_.keep_only(event.contact);
    ++idle_;
    return contacts_.restore(centre_, work_);
  } else if (event.slot >= 0) {
    if (event.time <= 0.0 && overlaps(near_.shape(event.slot))) return false;
    hint_ = path.slope(event.time);
    is_descending_ = true;
    return contacts_.add(OffsetContact::nearest(near_.triangle(event.slot), near_.shape(event.slot), centre_));
  }
  return true;
}

// Across an edge of a face the adjacent face may rise by so little that it was not hit before. Returns a slot; -1: none.
int SphereFollower::find_rising(const OffsetContact& contact, int edge, const Vec3& direction) noexcept {
  if (contact.part != Part::face) return -1;
  const OffsetContact shared_edge = OffsetContact::on_edge(contact.triangle, contact.shape, edge);
  int rising = -1;
  double least = -kLeastRise * direction.norm();
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

// Across an edge of a face the adjacent face may be coplanar: that edge has no part of the offset surface. Returns a slot; -1: none.
int SphereFollower::find_coplanar(const OffsetContact& contact, const Exit& exit) noexcept {
  if (contact.part != Part::face) return -1;
  const OffsetContact shared_edge = OffsetContact::on_edge(contact.triangle, contact.shape, exit.index);
  int level = -1;
  near_.visit_near(centre_, centre_, clearance().offset + clearance().slop, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (near_.triangle(slot) == contact.triangle || !shared_edge.is_shared_with(shape) ||
        !near_.can_touch(near_.triangle(slot), shape, centre_))
      return;
    if (!(shape.normal().cross(contact.normal).squaredNorm() <= kLeastRise * kLeastRise) || !is_over(shape, centre_)) return;
    if (is_level_at(OffsetContact::on_face(near_.triangle(slot), shape, contact.normal), centre_)) level = slot;
  });
  return level;
}

// Moves the contact to the part beyond the boundary.
void SphereFollower::move_to_next_part(int i, const Exit& exit, const Vec3& direction) noexcept {
  OffsetContact& contact = contacts_[i];
  hint_ = direction;
  const Vec3 normal = contact.proximity(centre_).normal;
  const std::uint32_t triangle = exit.slot < 0 ? contact.triangle : near_.triangle(exit.slot);
  const ContactTriangle shape = exit.slot < 0 ? contact.shape : near_.shape(exit.slot);
  if (exit.part == Part::face) {
    contact = OffsetContact::on_face(triangle, shape, normal);
  } else if (exit.part == Part::edge) {
    contact = OffsetContact::on_edge(triangle, shape, exit.index);
  } else {
    contact = OffsetContact::on_vertex(triangle, shape, exit.index);
  }
}

}  // namespace hapton
