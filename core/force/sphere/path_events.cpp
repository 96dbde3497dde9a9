#include "core/force/sphere/path_events.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapton {
namespace {

// Calls visit(direction, edge) for each edge of a triangle that has an end at `vertex`. direction: unit, away from the vertex.
template <class Visit>
void visit_edges_at(const Vec3& vertex, const ObjectGeometry::Corners& corners, Visit&& visit) {
  const std::array<const Vec3*, 3> corner = {&corners.a, &corners.b, &corners.c};
  for (int k = 0; k < 3; ++k) {
    const Vec3& first = *corner[k];
    const Vec3& last = *corner[(k + 1) % 3];
    if (first != vertex && last != vertex) continue;
    const Vec3 edge = last - first;
    const double length = std::sqrt(edge.squaredNorm());
    if (length > 0.0) visit(Vec3(edge * ((first == vertex ? 1.0 : -1.0) / length)), k);
  }
}

}  // namespace

bool PathEvents::find(const CentrePath& path, Event& event) noexcept {
  // A path over a face often leaves it long before its end, so triangles are gathered later. Edges and vertices need them for their exits.
  const bool is_curved = !contacts_.is_flat();
  if (is_curved && !near_.cover(path, event.time, work_)) return false;
  const double reach = contacts_.offset() + path.bulge() + contacts_.clearance().slop;
  CentrePath::Prefix prefix = path.prefix(event.time);
  if (is_curved) {
    if (!find_candidates(path, reach, prefix)) return false;
    event.time = prefix.until;
  }
  for (int i = 0; i < contacts_.active_count(); ++i) {
    LevelFaces& crossed = space_.crossed[i];
    crossed.until = 0.0;
    Event exit = event;
    find_first_exit(path, i, prefix, exit);
    if (exit.contact != i) continue;
    if (contacts_[i].part == Feature::face) {
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
    if (!find_candidates(path, reach, prefix)) return false;
    event.time = prefix.until;
    if (event.time < exit_time) event.contact = -1;
  }
  const bool is_on_plane =
      (path.is_straight() || contacts_.active_count() == 1) && contacts_.active_count() > 0 && contacts_[0].part == Feature::face;
  Tangents tangents;
  for (int i = 0; i < space_.count; ++i) {
    const int slot = space_.candidates[i];
    if (near_.distance_bound(slot, path.start()) > reach && near_.distance_bound(slot, prefix.end) > reach) continue;
    if (cannot_stop(slot, path.start(), is_on_plane)) continue;
    const ContactTriangle& shape = near_.shape(slot);
    if (tangents.count < 0) find_tangents(path, tangents);
    if (is_below(tangents, shape)) continue;
    const CentrePath::Block block =
        path.find_block(shape, contacts_.clearance(), path.is_straight() ? 0U : contacts_.guiding_corners(shape), prefix, work_);
    if (!(block.time < event.time)) continue;
    event.time = block.time;
    event.contact = -1;
    event.slot = block.hits ? slot : -1;
    prefix = path.prefix(event.time);
  }
  move_to_last_level_face(path, event);
  return true;
}

// Finds the first time at which a contact leaves its part, up to the time of the event. If there is one, it becomes the event.
void PathEvents::find_first_exit(const CentrePath& path, int contact, CentrePath::Prefix& prefix, Event& event) noexcept {
  visit_exits(contacts_[contact], [&](const Exit& exit) {
    const double time = path.time_to_cross(exit.origin, exit.direction, kOnBoundary, prefix);
    if (time > event.time || (time == event.time && event.contact >= 0)) return;
    const bool is_face_here = time <= 0.0 && exit.slot >= 0 && exit.part == Feature::face;
    if (is_face_here && is_past_needle(near_.shape(exit.slot), exit.index, path.start())) return;
    event.time = time;
    event.contact = contact;
    event.exit = exit;
    prefix = path.prefix(time);
  });
}

// At an edge where the next face lies in the same plane, only the contact's triangle changes. Follows the path over such faces, from the
// exit in `event`: until it leaves them (true: `event` has that exit, `contact` the face before it), or up to `until` (false).
bool PathEvents::cross_level_faces(const CentrePath& path, double until, OffsetContact& contact, Event& event) const noexcept {
  constexpr int kMaxFaces = 1024;  // a bound on the work; after these, the last exit is the event
  for (int n = 0; n < kMaxFaces; ++n) {
    work_ += path.is_straight() ? n % 2 : 2;
    OffsetContact level;
    const double here = event.time;
    if (!find_level_face(contact, event.exit.index, path.at(here), level)) return true;
    Exit exit;
    const double then = time_off_face(path, level.shape, here, until, exit);
    const bool leaves = then <= until;
    if (!is_level_at(level, path.at(leaves ? then : until))) return true;
    contact = level;
    if (!leaves) return false;
    event.time = then;
    event.exit = exit;
  }
  return true;
}

double PathEvents::time_off_face(const CentrePath& path, const ContactTriangle& face, double from, double until, Exit& exit) noexcept {
  double first = kNever;
  for (int k = 0; k < 3; ++k) {
    const Exit over = edge_of(face, k);
    const double time = path.time_to_cross(over.origin, over.direction, kOnBoundary, from, until);
    if (!(time < first)) continue;
    first = time;
    exit = over;
  }
  return first;
}

// Finds the face beyond an edge, if its plane is the same within rounding where the centre, at c, crosses to it. The normals of two needles
// in one plane differ by the rounding of their corners over their heights: at most 2^-51 / 2^-15. The force turns by less than that.
bool PathEvents::find_level_face(const OffsetContact& contact, int edge, const Vec3& c, OffsetContact& level) const noexcept {
  constexpr double kMaxTilt = 0x1p-36;  // rad
  const TouchGeometry::Adjacent across = near_.geometry().adjacent(contact.triangle, edge);
  if (!across.exists || across.id == contact.triangle) return false;
  const ObjectGeometry::Corners corners = near_.geometry().corners(across.id);
  const ContactTriangle shape(corners.a, corners.b, corners.c);
  if (!(shape.normal().cross(contact.normal).squaredNorm() <= kMaxTilt * kMaxTilt) || !is_over(shape, c)) return false;
  if (!near_.can_touch(across.id, shape, c)) return false;
  level = OffsetContact::on_face(across.id, shape, contact.normal);
  return is_level_at(level, c);
}

bool PathEvents::is_level_at(const OffsetContact& face, const Vec3& c) const noexcept {
  return std::fabs(face.proximity(c).distance - contacts_.offset()) <= kCoplanar;
}

bool PathEvents::is_over(const ContactTriangle& shape, const Vec3& c) noexcept {
  return shape.inside(0, c) > 0.0 && shape.inside(1, c) > 0.0 && shape.inside(2, c) > 0.0;
}

// Moves contacts that cross faces of one plane on the way to the last of these faces before the event.
void PathEvents::move_to_last_level_face(const CentrePath& path, const Event& event) noexcept {
  for (int i = 0; i < contacts_.active_count(); ++i) {
    LevelFaces& crossed = space_.crossed[i];
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

// Whether a triangle cannot stop the centre, whatever its distance. Triangles below the plane of a face are never nearer than that face,
// for a centre that moves over the face.
bool PathEvents::cannot_stop(int slot, const Vec3& from, bool is_on_plane) noexcept {
  const std::uint32_t triangle = near_.triangle(slot);
  const ObjectGeometry::Corners corners = near_.geometry().corners(triangle);
  if (is_on_plane) {
    const Vec3& up = contacts_[0].normal;
    const double level = up.dot(from) - contacts_.offset() + 0.25 * contacts_.clearance().slop;
    if (std::max({up.dot(corners.a), up.dot(corners.b), up.dot(corners.c)}) <= level) return true;
  }
  if (contacts_.holds_part_of(corners, triangle)) return true;
  return !near_.material(triangle).two_sided && !near_.can_touch(triangle, near_.shape(slot), from);
}

// Finds the tangent planes at the ends of the path. Over a face both are its own plane. Over an edge the plane turns about the edge, and
// only in one sense if the path does not turn back. This is checked for the cubic, with a margin for its difference from the curve.
void PathEvents::find_tangents(const CentrePath& path, Tangents& tangents) const noexcept {
  // Shares of the mean speed. A cubic does not turn back if its speed at both ends is 0 to 3 times the mean (Fritsch & Carlson 1980).
  constexpr double kMinPace = 0.25;
  constexpr double kMaxPace = 2.5;
  tangents.count = 0;
  if (!path.is_guided() && !path.is_straight()) return;
  for (int i = 0; i < contacts_.active_count(); ++i) {
    const OffsetContact& contact = contacts_[i];
    TangentSpan& span = tangents.spans[tangents.count];
    if (contact.part == Feature::face) {
      span = {contact.shape.corner(0), {contact.normal, contact.normal}};
      ++tangents.count;
    } else if (contact.part == Feature::edge && path.is_guided()) {
      span = {contact.origin(), {contact.proximity(path.start()).normal, contact.proximity(path.end()).normal}};
      const Vec3 turn = contacts_.offset() * (span.normal[1] - span.normal[0]);
      const double whole = turn.squaredNorm();
      const double first = turn.dot(path.slope(0.0));
      const double last = turn.dot(path.slope(1.0));
      if (std::min(first, last) >= kMinPace * whole && std::max(first, last) <= kMaxPace * whole) ++tangents.count;
    }
  }
}

// Whether a triangle is below the tangent planes of one contact all along the path: it is then never nearer than that contact.
bool PathEvents::is_below(const Tangents& tangents, const ContactTriangle& shape) const noexcept {
  const double level = 0.25 * contacts_.clearance().slop;
  for (int i = 0; i < tangents.count; ++i) {
    const TangentSpan& span = tangents.spans[i];
    double highest = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Vec3 off = shape.corner(k) - span.origin;
      highest = std::max({highest, span.normal[0].dot(off), span.normal[1].dot(off)});
    }
    if (highest <= level) return true;
  }
  return false;
}

// Collects the triangles that may come within `reach` of the path, from its start to prefix.end. If they are many because the gathered ball
// is not centred on the start, gathers triangles again around the start. False: they cannot be gathered.
bool PathEvents::find_candidates(const CentrePath& path, double reach, CentrePath::Prefix& prefix) noexcept {
  constexpr int kMany = 32;  // triangles; a free choice
  note_candidates(path.start(), prefix.end, reach);
  if (space_.count <= kMany || near_.is_central(path.start())) return true;
  double until = prefix.until;
  if (!near_.gather(path.start(), Vec3::Zero(), work_) || !near_.cover(path, until, work_)) return false;
  if (until < prefix.until) prefix = path.prefix(until);
  note_candidates(path.start(), prefix.end, reach);
  return true;
}

// Collects the triangles that may come within `reach` of the segment.
void PathEvents::note_candidates(const Vec3& from, const Vec3& to, double reach) noexcept {
  space_.count = 0;
  near_.visit_near(from, to, reach, [&](int slot) { space_.candidates[space_.count++] = slot; });
}

// Calls visit(exit) for the boundaries of the part that a contact is on. Pre: for an edge or a vertex, call note_candidates() before.
template <class Visit>
void PathEvents::visit_exits(const OffsetContact& contact, Visit&& visit) noexcept {
  const ContactTriangle& own = contact.shape;
  if (contact.part == Feature::face) {
    for (int k = 0; k < 3; ++k) visit(edge_of(own, k));
    return;
  }
  if (contact.part == Feature::edge) {
    visit(Exit{contact.end(), contact.axis, -1, (contact.index + 1) % 3, Feature::vertex});
    visit(Exit{contact.origin(), -contact.axis, -1, contact.index, Feature::vertex});
  }
  for (int i = 0; i < space_.count; ++i) {
    const int slot = space_.candidates[i];
    const ObjectGeometry::Corners corners = near_.geometry().corners(near_.triangle(slot));
    if (!contact.is_shared_with(corners.a, corners.b, corners.c)) continue;
    if (contact.part == Feature::vertex) {
      visit_edges_at(contact.origin(), corners, [&](const Vec3& outwards, int k) {
        visit(Exit{contact.origin(), outwards, slot, k, Feature::edge});
      });
      continue;
    }
    const ContactTriangle& shape = near_.shape(slot);
    for (int k = 0; k < 3; ++k) {
      const Vec3& first = shape.corner(k);
      const Vec3& last = shape.corner((k + 1) % 3);
      if (!(shape.length(k) > 0.0) || shape.normal().isZero(0.0)) continue;
      if (!(first == contact.origin() && last == contact.end()) && !(last == contact.origin() && first == contact.end())) continue;
      visit(Exit{first, shape.normal().cross(shape.edge(k)) / shape.length(k), slot, k, Feature::face});
    }
  }
}

// Whether the centre, in contact with an edge of a triangle, is clearly inside that edge but clearly outside another one, as seen along the
// normal. This is so at a needle that rises by less than the slop and so was not hit: its face never holds the sphere.
bool PathEvents::is_past_needle(const ContactTriangle& shape, int edge, const Vec3& c) const noexcept {
  const auto height = [&](int k) { return shape.inside(k, c) / shape.length(k); };
  return height(edge) > contacts_.clearance().slop &&
         std::min(height((edge + 1) % 3), height((edge + 2) % 3)) < -contacts_.clearance().slop;
}

double PathEvents::distance_to_boundary(const Vec3& c, const Vec3& direction, double most) noexcept {
  constexpr double kBeyond = 1.25;          // times the distance, so that a leg of that length passes the boundary
  constexpr double kMinDistance = 0x1p-10;  // share of the offset
  if (contacts_[0].is_curved()) note_candidates(c, c, contacts_.offset() + contacts_.clearance().slop);  // for visit_exits
  const CentrePath path = CentrePath::straight(c, c + most * direction);
  CentrePath::Prefix prefix = path.prefix(1.0);
  Event exit;
  find_first_exit(path, 0, prefix, exit);
  if (exit.contact < 0) return std::numeric_limits<double>::infinity();
  OffsetContact last = contacts_[0];
  if (last.part == Feature::face && !cross_level_faces(path, 1.0, last, exit)) return std::numeric_limits<double>::infinity();
  return kBeyond * exit.time * most + kMinDistance * contacts_.offset();
}

// If its tangent turns by less than a quarter turn, the path lies in the triangle between its chord and the tangents at its ends. The chord
// is the longest side of that triangle, whose height is at most half the chord times the sine of the turn. The distance to a mesh triangle
// is convex, so it is never below its linear approximations, which are least at a corner of the triangle around the path.
bool PathEvents::is_clear_over_face(const Vec3& c, const Vec3& end, const Vec3& direction, const Vec3& direction_there) noexcept {
  if (!(direction.dot(direction_there) > 0.0)) return false;
  const Vec3 path = end - c;
  const double chord = path.norm();
  // An upper bound of a linear function on the path, less its value at the start; the next one: less its value at the end.
  const auto most_from_start = [&](const Vec3& gradient) { return std::max({0.0, gradient.dot(path), chord * gradient.dot(direction)}); };
  const auto most_from_end = [&](const Vec3& gradient) {
    return std::max({0.0, -gradient.dot(path), -chord * gradient.dot(direction_there)});
  };
  const ContactTriangle& face = contacts_[0].shape;
  for (int k = 0; k < 3; ++k) {
    const Exit over = edge_of(face, k);
    const double height = over.direction.dot(c - over.origin) + most_from_start(over.direction);
    const double height_by_end = over.direction.dot(end - over.origin) + most_from_end(over.direction);
    if (!(std::min(height, height_by_end) <= kOnBoundary)) return false;
  }
  const double reach = contacts_.offset() + 0.5 * chord * direction.cross(direction_there).norm() + contacts_.clearance().slop;
  if (!near_.covers(c, reach) || !near_.covers(end, reach)) return false;
  note_candidates(c, end, reach);
  for (int i = 0; i < space_.count; ++i) {
    const int slot = space_.candidates[i];
    if (cannot_stop(slot, c, true)) continue;
    ++work_;
    const Separation here = near_.shape(slot).separation(c);
    const double least = std::min(here.distance, contacts_.offset() - 0.25 * contacts_.clearance().slop);
    if (here.distance - most_from_start(-here.normal) >= least) continue;
    ++work_;
    const Separation there = near_.shape(slot).separation(end);
    if (!(there.distance - most_from_end(-there.normal) >= least)) return false;
  }
  return true;
}

}  // namespace hapton
