#include "core/force/sphere/offset_surface.h"

#include <algorithm>
#include <cmath>

namespace hapton {

OffsetContact OffsetContact::on_face(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& towards) noexcept {
  OffsetContact contact{.triangle = triangle, .shape = shape, .back = shape.normal().dot(towards) < 0.0};
  contact.normal = contact.back ? Vec3(-shape.normal()) : shape.normal();
  return contact;
}

OffsetContact OffsetContact::on_edge(std::uint32_t triangle, const ContactTriangle& shape, int edge) noexcept {
  if (!(shape.length(edge) > 0.0)) return on_vertex(triangle, shape, edge);
  return {.part = Feature::edge, .triangle = triangle, .shape = shape, .index = edge, .axis = shape.edge(edge) / shape.length(edge)};
}

OffsetContact OffsetContact::on_vertex(std::uint32_t triangle, const ContactTriangle& shape, int corner) noexcept {
  return {.part = Feature::vertex, .triangle = triangle, .shape = shape, .index = corner};
}

OffsetContact OffsetContact::nearest(std::uint32_t triangle, const ContactTriangle& shape, const Vec3& c) noexcept {
  bool is_inside = !shape.normal().isZero(0.0);
  double best = std::numeric_limits<double>::infinity();
  int edge = 0;
  double along = 0.0;
  for (int k = 0; k < 3; ++k) {
    if (is_inside && shape.inside(k, c) > 0.0) continue;
    const double t = std::clamp(shape.along(k, c), 0.0, 1.0);
    const double squared = (c - shape.corner(k) - t * shape.edge(k)).squaredNorm();
    if (squared < best) {
      best = squared;
      edge = k;
      along = t;
    }
  }
  if (!(best < std::numeric_limits<double>::infinity())) return on_face(triangle, shape, c - shape.corner(0));
  if (along <= 0.0) return on_vertex(triangle, shape, edge);
  if (along >= 1.0) return on_vertex(triangle, shape, (edge + 1) % 3);
  return on_edge(triangle, shape, edge);
}

OffsetContact::Proximity OffsetContact::proximity(const Vec3& c) const noexcept {
  if (part == Feature::face) return {normal.dot(c - origin()), normal};
  Vec3 off = c - origin();
  if (part == Feature::edge) {
    off -= axis.dot(off) * axis;
    off -= axis.dot(off) * axis;  // removes the rounding error of the line before
  }
  const double distance = off.norm();
  return {distance, distance > 0.0 ? Vec3(off / distance) : Vec3::UnitX()};
}

double OffsetContact::curvature(const Vec3& tangent, double offset) const noexcept {
  if (!is_curved()) return 0.0;
  if (part == Feature::vertex) return 1.0 / offset;
  const double straight = axis.dot(tangent);
  return std::max(0.0, 1.0 - straight * straight) / offset;
}

CentrePath::Guide OffsetContact::guide(double offset) const noexcept {
  return {part, origin(), part == Feature::face ? normal : axis, offset};
}

bool OffsetContact::is_shared_with(const Vec3& a, const Vec3& b, const Vec3& c) const noexcept {
  const auto has = [&](const Vec3& p) { return a == p || b == p || c == p; };
  if (part == Feature::vertex) return has(origin());
  if (part == Feature::edge) return has(origin()) && has(end());
  return has(shape.corner(0)) && has(shape.corner(1)) && has(shape.corner(2));
}

bool OffsetContact::is_same_part(const OffsetContact& other) const noexcept {
  if (part != other.part || part == Feature::face) return false;
  const Vec3& other_end = part == Feature::edge ? other.end() : other.origin();
  return is_shared_with(other.origin(), other_end, other_end);
}

}  // namespace hapton
