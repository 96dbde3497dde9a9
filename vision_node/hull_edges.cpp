#include "vision_node/hull_edges.h"

#include <algorithm>

namespace hapton {
namespace {

using Polygon = std::vector<Vec3>;

// The part of the polygon where normal . p <= limit (Sutherland and Hodgman).
Polygon clip_polygon(const Polygon& polygon, const Vec3& normal, double limit) {
  Polygon clipped;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& p = polygon[i];
    const Vec3& q = polygon[(i + 1) % polygon.size()];
    const double at_p = normal.dot(p) - limit;
    const double at_q = normal.dot(q) - limit;
    if (at_p <= 0.0) clipped.push_back(p);
    if ((at_p < 0.0 && at_q > 0.0) || (at_p > 0.0 && at_q < 0.0)) clipped.push_back(p + at_p / (at_p - at_q) * (q - p));
  }
  return clipped;
}

// A square that is larger than the box, in the plane normal . p = limit.
Polygon make_square(const Vec3& middle, const Vec3& normal, double limit, double size) {
  const Vec3 n = normal.normalized();
  const Vec3 u = n.unitOrthogonal();
  const Vec3 v = n.cross(u);
  const Vec3 at = middle + (limit / normal.norm() - n.dot(middle)) * n;
  return {at + size * (u + v), at + size * (v - u), at - size * (u + v), at + size * (u - v)};
}

}  // namespace

std::vector<HullEdge> find_hull_edges(const std::vector<HullSlab>& slabs) {
  if (slabs.size() < 3) return {};
  const Vec3 low(slabs[0].low, slabs[1].low, slabs[2].low);
  const Vec3 high(slabs[0].high, slabs[1].high, slabs[2].high);
  const double size = (high - low).norm();
  std::vector<HullEdge> edges;
  for (std::size_t s = 0; s < slabs.size(); ++s) {
    for (const double side : {-1.0, 1.0}) {
      const Vec3 normal = side * slabs[s].axis;
      Polygon face = make_square(0.5 * (low + high), normal, side > 0.0 ? slabs[s].high : -slabs[s].low, size);
      for (std::size_t other = 0; other < slabs.size() && !face.empty(); ++other) {
        if (other == s) continue;
        face = clip_polygon(face, slabs[other].axis, slabs[other].high);
        if (!face.empty()) face = clip_polygon(face, -slabs[other].axis, -slabs[other].low);
      }
      for (std::size_t i = 0; i < face.size(); ++i) edges.emplace_back(face[i], face[(i + 1) % face.size()]);
    }
  }
  // Two faces meet at each edge, but it is kept once. An edge that is no longer than a rounding error is a corner.
  const double tolerance = 1e-7 * size;
  std::vector<HullEdge> unique_edges;
  for (const HullEdge& edge : edges) {
    if ((edge.first - edge.second).norm() <= tolerance) continue;
    const auto is_same = [&](const HullEdge& known) {
      return ((known.first - edge.second).norm() <= tolerance && (known.second - edge.first).norm() <= tolerance) ||
             ((known.first - edge.first).norm() <= tolerance && (known.second - edge.second).norm() <= tolerance);
    };
    if (std::none_of(unique_edges.begin(), unique_edges.end(), is_same)) unique_edges.push_back(edge);
  }
  return unique_edges;
}

}  // namespace hapton
