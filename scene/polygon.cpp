#include "scene/polygon.h"

#include <algorithm>
#include <numeric>

namespace hapton {
namespace {

using Vec2 = Eigen::Vector2d;

// Newell's normal: twice the area vector, whatever the polygon's shape. Taken about the first corner against cancellation.
Vec3 area_normal(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices) {
  const Vec3& origin = vertices[corners[0]];
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    normal += (vertices[corners[i]] - origin).cross(vertices[corners[i + 1]] - origin);
  }
  return normal;
}

double turn(const Vec2& a, const Vec2& b, const Vec2& c) { return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()); }

// The polygon seen along its normal, counter-clockwise.
std::vector<Vec2> flatten(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices, const Vec3& normal) {
  int drop = 0;
  normal.cwiseAbs().maxCoeff(&drop);
  int u = (drop + 1) % 3;
  int v = (drop + 2) % 3;
  if (normal[drop] < 0) std::swap(u, v);
  std::vector<Vec2> flat;
  for (const std::uint32_t corner : corners) flat.emplace_back(vertices[corner][u], vertices[corner][v]);
  return flat;
}

bool is_convex(const std::vector<Vec2>& flat) {
  const std::size_t n = flat.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) < 0) return false;
  }
  return true;
}

// An ear: a corner that turns left with no other corner in or on its triangle.
bool is_ear(const std::vector<Vec2>& flat, const std::vector<std::uint32_t>& ring, std::size_t i) {
  const std::size_t n = ring.size();
  const Vec2& a = flat[ring[(i + n - 1) % n]];
  const Vec2& b = flat[ring[i]];
  const Vec2& c = flat[ring[(i + 1) % n]];
  if (!(turn(a, b, c) > 0)) return false;
  return std::none_of(ring.begin(), ring.end(), [&](std::uint32_t corner) {
    const Vec2& p = flat[corner];
    if (p == a || p == b || p == c) return false;
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
  });
}

bool add_fan(std::span<const std::uint32_t> corners, std::vector<Triangle>& into) {
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) into.push_back({corners[0], corners[i], corners[i + 1]});
  return true;
}

// False, with some of the triangles appended, when no ear is left to cut.
bool cut_ears(std::span<const std::uint32_t> corners, const std::vector<Vec2>& flat, std::vector<Triangle>& into) {
  std::vector<std::uint32_t> ring(corners.size());
  std::iota(ring.begin(), ring.end(), 0U);
  std::size_t ear = 0;
  for (std::size_t misses = 0; ring.size() > 3;) {
    const std::size_t n = ring.size();
    ear %= n;
    if (!is_ear(flat, ring, ear)) {
      if (++misses == n) return false;
      ++ear;
      continue;
    }
    into.push_back({corners[ring[(ear + n - 1) % n]], corners[ring[ear]], corners[ring[(ear + 1) % n]]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    misses = 0;
  }
  into.push_back({corners[ring[0]], corners[ring[1]], corners[ring[2]]});
  return true;
}

}  // namespace

bool triangulate_polygon(std::span<const std::uint32_t> corners, std::span<const Vec3> vertices, std::vector<Triangle>& into) {
  if (corners.size() == 3) return add_fan(corners, into);
  const std::vector<Vec2> flat = flatten(corners, vertices, area_normal(corners, vertices));
  if (is_convex(flat)) return add_fan(corners, into);
  if (corners.size() > kMaxPolygonCorners) return false;
  const std::size_t before = into.size();
  if (cut_ears(corners, flat, into)) return true;
  into.resize(before);
  return add_fan(corners, into);
}

}  // namespace hapton
