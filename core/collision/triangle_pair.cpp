#include "core/collision/triangle_pair.h"

#include <algorithm>
#include <cmath>

#include "core/math/orient3d.h"

namespace hapton {
namespace {

using Corners = std::array<Vec3, 3>;

// A triangle and its heights over another's plane, renumbered in cycle so that corner 0 is strictly the highest or strictly the lowest.
struct Turned {
  Corners corner;
  std::array<double, 3> height;  // times twice the other's area; > 0 on the side of the other's normal
  bool is_on_top = false;        // corner 0 is the highest
};

// orient3d of the plane and each corner; the first stage, which may be inexact, computes the plane's normal once for all three corners.
std::array<double, 3> heights_over(const Corners& plane, const Corners& corner) {
  const Vec3 u = plane[1] - plane[0];
  const Vec3 v = plane[2] - plane[0];
  const Vec3 normal = u.cross(v);
  const Vec3 largest = u.cwiseAbs().cwiseMax(v.cwiseAbs());
  std::array<double, 3> height;
  for (int i = 0; i < 3; ++i) {
    const Vec3 w = corner[i] - plane[0];
    height[i] = normal.dot(w);
    const double size = largest.cwiseMax(w.cwiseAbs()).prod();
    if (!(std::fabs(height[i]) > kAccurateDeterminant * size)) height[i] = orient3d_exact(plane[0], plane[1], plane[2], corner[i]);
  }
  return height;
}

bool is_beside(const std::array<double, 3>& height) {
  return (height[0] > 0.0 && height[1] > 0.0 && height[2] > 0.0) || (height[0] < 0.0 && height[1] < 0.0 && height[2] < 0.0);
}

bool is_all_zero(const std::array<double, 3>& height) { return height[0] == 0.0 && height[1] == 0.0 && height[2] == 0.0; }

int sign_of(double x) { return x > 0.0 ? 1 : x < 0.0 ? -1 : 0; }

// Pre: not all signs are equal, so the sign of one corner is strictly above or strictly below those of the other two.
Turned turn(const Corners& corner, const std::array<double, 3>& height) {
  const std::array<int, 3> s = {sign_of(height[0]), sign_of(height[1]), sign_of(height[2])};
  int first = 0;
  bool is_on_top = false;
  for (int i = 0; i < 3; ++i) {
    const int next = s[(i + 1) % 3];
    const int last = s[(i + 2) % 3];
    if (s[i] > next && s[i] > last) {
      first = i;
      is_on_top = true;
      break;
    }
    if (s[i] < next && s[i] < last) first = i;
  }
  const int second = (first + 1) % 3;
  const int third = (first + 2) % 3;
  return {{corner[first], corner[second], corner[third]}, {height[first], height[second], height[third]}, is_on_top};
}

// Where the edge from corner 0 to corner i crosses the other triangle's plane. Exact if one of these corners lies in that plane.
Vec3 pierce(const Turned& t, int i) {
  if (t.height[i] == 0.0) return t.corner[i];
  return t.corner[0] + t.height[0] / (t.height[0] - t.height[i]) * (t.corner[i] - t.corner[0]);
}

// --- Coplanar triangles ------------------------------------------------------------------------------------------------------------

// Twice the area of p, q, r projected along an axis, with an exact sign: the third row of the determinant is that axis.
double projected_area(const Vec3& p, const Vec3& q, const Vec3& r, int axis) {
  Vec3 a = p;
  Vec3 b = q;
  Vec3 c = r;
  a[axis] = b[axis] = c[axis] = 0.0;
  Vec3 above = a;
  above[axis] = 1.0;
  return orient3d(a, b, c, above);
}

// An axis along which the projection of the triangle has an area. -1: there is none, because the triangle is degenerate.
int find_projection_axis(const Corners& t) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]).cwiseAbs();
  std::array<int, 3> axes = {0, 1, 2};
  std::sort(axes.begin(), axes.end(), [&](int i, int j) { return n[i] > n[j]; });
  for (const int axis : axes) {
    if (projected_area(t[0], t[1], t[2], axis) != 0.0) return axis;
  }
  return -1;
}

struct SharedPoints {
  std::array<Vec3, 15> point;
  int count = 0;
};

bool is_inside(const Vec3& p, const Corners& t, int axis) {
  const double side = projected_area(t[0], t[1], t[2], axis);
  for (int i = 0; i < 3; ++i) {
    if (projected_area(t[i], t[(i + 1) % 3], p, axis) * (side > 0.0 ? 1.0 : -1.0) < 0.0) return false;
  }
  return true;
}

// The corners of the intersection of two coplanar triangles: corners of one inside the other, and crossings of edges.
SharedPoints shared_points(const Corners& a, const Corners& b, int axis) {
  SharedPoints shared;
  for (const Vec3& p : a) {
    if (is_inside(p, b, axis)) shared.point[shared.count++] = p;
  }
  for (const Vec3& p : b) {
    if (is_inside(p, a, axis)) shared.point[shared.count++] = p;
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vec3& p = a[i];
      const Vec3& q = a[(i + 1) % 3];
      const Vec3& r = b[j];
      const Vec3& s = b[(j + 1) % 3];
      const double from = projected_area(r, s, p, axis);
      const double to = projected_area(r, s, q, axis);
      if (sign_of(from) * sign_of(to) >= 0 || sign_of(projected_area(p, q, r, axis)) * sign_of(projected_area(p, q, s, axis)) >= 0)
        continue;
      shared.point[shared.count++] = p + from / (from - to) * (q - p);
    }
  }
  return shared;
}

TriangleContact intersect_coplanar(const Corners& a, const Corners& b, int axis) {
  TriangleContact contact;
  contact.coplanar = true;
  const SharedPoints shared = shared_points(a, b, axis);
  if (shared.count == 0) return contact;
  contact.meets = true;
  contact.begin = contact.end = shared.point[0];
  double longest = 0.0;
  for (int i = 0; i < shared.count; ++i) {
    for (int j = 0; j < i; ++j) {
      const double length = (shared.point[i] - shared.point[j]).squaredNorm();
      if (length <= longest) continue;
      longest = length;
      contact.begin = shared.point[j];
      contact.end = shared.point[i];
    }
  }
  return contact;
}

}  // namespace

// Let u be an edge of a from its corner 0, v one of b, p and q the points where u and v cross the other's plane, and D = normal(a) x
// normal(b). Then det(u, b0 - a0, v) = (q - p) . (v x u), and D . (v x u) = (v . normal(a)) (u . normal(b)), as u lies in a's plane and v
// in b's. So the sign of det tells which of p and q comes first along D, reversed once for each triangle whose corner 0 is the lowest.
// Along D a triangle's crossing points, on its edges to corners 1 and 2, come in the order 2, 1 if a is on top, and 1, 2 if b is on top.
TriangleContact intersect_triangles(const TrianglePair& pair) noexcept {
  const std::array<double, 3> over_b = heights_over(pair.b, pair.a);
  if (is_beside(over_b)) return {};
  const std::array<double, 3> over_a = heights_over(pair.a, pair.b);
  if (is_beside(over_a)) return {};
  if (is_all_zero(over_a) || is_all_zero(over_b)) {
    const int axis_a = find_projection_axis(pair.a);
    const int axis_b = find_projection_axis(pair.b);
    return axis_a < 0 || axis_b < 0 ? TriangleContact{} : intersect_coplanar(pair.a, pair.b, axis_a);
  }
  const Turned a = turn(pair.a, over_b);
  const Turned b = turn(pair.b, over_a);
  const int a_low = a.is_on_top ? 2 : 1;
  const int a_high = 3 - a_low;
  const int b_low = b.is_on_top ? 1 : 2;
  const int b_high = 3 - b_low;
  const double orientation = a.is_on_top == b.is_on_top ? 1.0 : -1.0;
  const auto b_is_later = [&](int i, int j) { return orientation * orient3d_sign(a.corner[0], a.corner[i], b.corner[0], b.corner[j]); };
  if (b_is_later(a_low, b_high) < 0.0 || b_is_later(a_high, b_low) > 0.0) return {};
  TriangleContact contact;
  contact.meets = true;
  contact.begin = b_is_later(a_low, b_low) > 0.0 ? pierce(b, b_low) : pierce(a, a_low);
  contact.end = b_is_later(a_high, b_high) > 0.0 ? pierce(a, a_high) : pierce(b, b_high);
  return contact;
}

std::size_t intersect_pairs(std::span<const TrianglePair> pairs, std::span<TriangleContact> contacts) noexcept {
  std::size_t fallbacks = 0;
  TrianglePairs8 packed;
  TriangleContacts8 found;
  for (std::size_t first = 0; first < pairs.size(); first += 8) {
    const int count = static_cast<int>(std::min<std::size_t>(8, pairs.size() - first));
    if (count == 8) {
      pack_8(&pairs[first], packed);
    } else {
      for (int lane = 0; lane < 8; ++lane) pack_pair(pairs[first + static_cast<std::size_t>(std::min(lane, count - 1))], lane, packed);
    }
    intersect_8(packed, found);
    for (int lane = 0; lane < count; ++lane) {
      const TrianglePair& pair = pairs[first + lane];
      TriangleContact& contact = contacts[first + lane];
      if ((found.undecided >> lane & 1) != 0) {
        contact = intersect_triangles(pair);
        ++fallbacks;
        continue;
      }
      contact.meets = (found.meets >> lane & 1) != 0;
      contact.coplanar = false;
      contact.begin = pair.a[0] + Vec3(found.begin[0][lane], found.begin[1][lane], found.begin[2][lane]);
      contact.end = pair.a[0] + Vec3(found.end[0][lane], found.end[1][lane], found.end[2][lane]);
    }
  }
  return fallbacks;
}

}  // namespace hapton
