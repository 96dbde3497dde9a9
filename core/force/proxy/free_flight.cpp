#include "core/force/proxy/free_flight.h"

#include <algorithm>

#include "core/math/side_sign.h"

namespace hapton {

FreeFlight::Met FreeFlight::fly(const Vec3& from, const Vec3& to, bool slides, SurfaceFollower& surface, double& time) noexcept {
  tests_ = 0;
  const TouchGeometry& geometry = surfaces_.geometry();
  Met met = Met::nothing;
  std::uint32_t first = 0;
  TouchGeometry::Hit hit;
  const Vec3 motion = to - from;
  geometry.visit_along(from, to, clearance_.offset, [&](std::uint32_t id, double until) {
    ++tests_;
    if (!geometry.is_walkable(id)) {
      if (!surfaces_.can_touch(id, from) || time_to_block(TriangleView{geometry, id}, from, motion, until, clearance_) > until)
        return until;
      met = Met::other;
      return 0.0;
    }
    const TouchGeometry::Hit at = geometry.pierce(id, from, to);
    if (met == Met::other || at.time > until || (at.time == until && met == Met::walkable)) return until;
    if (at.from_back && !surfaces_.material_of(id).two_sided) return until;
    if (!is_seen_from(from, to, id, at.from_back, from + at.time * motion)) return until;
    met = Met::walkable;
    first = id;
    hit = at;
    return hit.time;
  });
  if (met != Met::walkable) return met;
  time = hit.time;
  const ContactTriangle shape = surfaces_.shape_of(first);
  const Vec3 at = from + time * motion;
  const Vec3 on_face = at - shape.normal().dot(at - shape.corner(0)) * shape.normal();
  return surface.land(first, hit.from_back, on_face, slides) ? Met::walkable : Met::other;
}

// A segment that crosses an edge passes, within rounding, through both triangles at this edge. A triangle counts only if p sees its side
// `back`: p must lie on that side of the wedge that the two triangles form.
bool FreeFlight::is_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, const Vec3& hit) noexcept {
  // Local units: 2^11 times the grid, above the rounding of a crossing; 2^-10 of the contact offset.
  constexpr double kNearEdge = 0x1p-40;
  const TouchGeometry& geometry = surfaces_.geometry();
  const ContactTriangle shape = surfaces_.shape_of(id);
  const auto in_front = [](const ContactTriangle& of, const Vec3& point) {
    return side_sign(of.corner(0), of.corner(1), of.corner(2), point) > 0.0;
  };
  for (int k = 0; k < 3; ++k) {
    if (shape.inside(k, hit) > kNearEdge * shape.length(k)) continue;
    const TouchGeometry::Adjacent adjacent = geometry.adjacent(id, k);
    if (!adjacent.exists || adjacent.id == id) continue;
    const double along = shape.along(k, hit) * shape.length(k);
    if (!(along > kNearEdge)) {
      if (!is_vertex_seen_from(p, to, id, back, k, hit)) return false;
      continue;
    }
    if (!(shape.length(k) - along > kNearEdge)) continue;          // the vertex belongs to the next edge
    if (geometry.pierce(adjacent.id, p, to).time > 1.0) continue;  // the segment does not cross both
    const ContactTriangle other = surfaces_.shape_of(adjacent.id);
    const bool other_back = back != adjacent.flips;
    const bool is_convex = in_front(other, shape.corner((k + 2) % 3)) == other_back;
    const bool before = in_front(shape, p) != back;
    const bool before_other = in_front(other, p) != other_back;
    if (!(is_convex ? before || before_other : before && before_other)) return false;
  }
  return true;
}

// The same at a vertex, where more than two triangles meet. Along the segment, crossings from the front and from the back alternate, so the
// segment first meets the side that it crosses once more than the other.
bool FreeFlight::is_vertex_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, int k, const Vec3& hit) noexcept {
  if (!vertex_.land(id, back, hit) || !vertex_.reach_vertex(k)) return true;
  int crossing_balance = 0;
  tests_ += static_cast<int>(vertex_.fan().size());
  for (const SurfacePoint::FanFacet& facet : vertex_.fan()) {
    const TouchGeometry::Hit at = surfaces_.geometry().pierce(facet.id, p, to);
    if (at.time <= 1.0) crossing_balance += at.from_back == facet.back ? 1 : -1;
  }
  return crossing_balance != 0 ? crossing_balance > 0 : vertex_.is_before_fan(p);
}

Vec3 FreeFlight::clear_of_surfaces(const Vec3& p, double farthest) noexcept {
  // Local units, eight times the grid of coordinates: at a smaller distance, only rounding decides the direction.
  constexpr double kNoDirection = 0x1p-48;
  std::size_t count = 0;
  surfaces_.geometry().for_each_overlapping(Box{p, p}.inflated(clearance_.offset), [&](std::uint32_t id) {
    const ContactTriangle shape = surfaces_.shape_of(id);
    const Separation at = shape.separation(p);
    if (at.distance >= clearance_.offset || count == planes_.size() || !surfaces_.can_touch(id, p)) return;
    // So near to the triangle, only rounding decides the direction to its nearest point, also on an edge or a corner: the triangle's normal
    // is used instead. The side on which p lies is decided exactly.
    Vec3 normal = at.normal;
    const bool is_on_it = !(at.distance > kNoDirection) && !shape.normal().isZero(0.0);
    if (is_on_it || at.feature == Feature::face) {
      const double side = side_sign(shape.corner(0), shape.corner(1), shape.corner(2), p);
      if (is_on_it) normal = shape.normal();
      if ((side > 0.0) != (shape.normal().dot(normal) > 0.0)) normal = -normal;
    }
    planes_[count++] = {normal, clearance_.offset - normal.dot(p - at.nearest)};
  });
  if (count == 0) return p;
  const ConstrainedMotion off = constrain_motion(Vec3::Zero(), std::span(planes_).first(count));
  if (!off.solved || !(off.motion.norm() <= farthest)) return p;
  // In a narrow corner the motion is longer than the offset, and another triangle may be in its way.
  const Vec3 clear = p + off.motion;
  bool is_in_the_way = false;
  surfaces_.geometry().for_each_overlapping(Box::around(p, clear), [&](std::uint32_t id) {
    is_in_the_way = is_in_the_way || (surfaces_.geometry().pierce(id, p, clear).time <= 1.0 && surfaces_.can_touch(id, p) &&
                                      surfaces_.geometry().separation(id, p).distance >= clearance_.offset);
  });
  return is_in_the_way ? p : clear;
}

Vec3 FreeFlight::off_surface(const Vec3& p, double least) const noexcept {
  constexpr int kMaxFaces = 8;  // at an edge or vertex, each face in turn
  const TouchGeometry& geometry = surfaces_.geometry();
  Vec3 off = p;
  for (int i = 0; i < kMaxFaces; ++i) {
    std::uint32_t nearest = 0;
    double bound = least * least;
    bool any = false;
    geometry.visit_nearest(off, bound, [&](std::uint32_t triangle, double) {
      const double d = geometry.separation(triangle, off).distance;
      if (d * d < bound) {
        bound = d * d;
        nearest = triangle;
        any = true;
      }
      return bound;
    });
    if (!any) return off;
    const Vec3& a = geometry.corner(nearest, 0);
    const Vec3 normal = accurate_cross(geometry.corner(nearest, 1) - a, geometry.corner(nearest, 2) - a);
    const double length = normal.norm();
    off += (2.0 * least) * (length > 0.0 ? Vec3(normal / length) : geometry.separation(nearest, off).normal);
  }
  return off;
}

}  // namespace hapton
