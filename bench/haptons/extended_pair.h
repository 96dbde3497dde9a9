#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "core/collision/triangle_pair.h"

namespace hapton {

// Brute-force twin of intersect_triangles in long double (64 bits of mantissa): tests every edge of each triangle against the other, with
// its own short formulas. For pairs in general position: no edge of coplanar triangles pierces the other. RT: no.
struct ExtendedContact {
  using Real = long double;
  using Point = Eigen::Matrix<Real, 3, 1>;

  int count = 0;  // piercing points; 2 for intersecting pairs in general position
  std::array<Point, 6> point;
  std::array<bool, 6> on_edge_of_a;
};

inline ExtendedContact intersect_extended(const TrianglePair& pair) {
  using Real = ExtendedContact::Real;
  using Point = ExtendedContact::Point;
  ExtendedContact found;
  const auto pierce_all = [&](const std::array<Vec3, 3>& edges, const std::array<Vec3, 3>& face, bool edges_are_a) {
    const std::array<Point, 3> f = {face[0].cast<Real>(), face[1].cast<Real>(), face[2].cast<Real>()};
    const Point normal = (f[1] - f[0]).cross(f[2] - f[0]);
    for (int i = 0; i < 3; ++i) {
      const Point p = edges[i].cast<Real>();
      const Point q = edges[(i + 1) % 3].cast<Real>();
      const Real from = normal.dot(p - f[0]);
      const Real to = normal.dot(q - f[0]);
      if (!((from < 0) != (to < 0))) continue;
      const Point x = p + from / (from - to) * (q - p);
      bool inside = true;
      for (int k = 0; k < 3; ++k) inside = inside && normal.dot((f[(k + 1) % 3] - f[k]).cross(x - f[k])) >= 0;
      if (!inside) continue;
      found.point[found.count] = x;
      found.on_edge_of_a[found.count] = edges_are_a;
      ++found.count;
    }
  };
  pierce_all(pair.a, pair.b, true);
  pierce_all(pair.b, pair.a, false);
  return found;
}

// The larger of the distances of the contact's two ends from the two exact ends, with the ends paired in the order that fits better;
// infinity if an end is not finite. Pre: exact.count == 2.
inline double location_error(const TriangleContact& contact, const ExtendedContact& exact) {
  // std::fmax and std::fmin would leave a NaN out.
  if (!contact.begin.allFinite() || !contact.end.allFinite()) return std::numeric_limits<double>::infinity();
  const auto apart = [&](const Vec3& p, int i) { return static_cast<double>((p.cast<ExtendedContact::Real>() - exact.point[i]).norm()); };
  const double straight = std::fmax(apart(contact.begin, 0), apart(contact.end, 1));
  const double crossed = std::fmax(apart(contact.begin, 1), apart(contact.end, 0));
  return std::fmin(straight, crossed);
}

// The length to which the "0.1 %" of the hapton refers: the longest edge of the smaller triangle.
inline double size_of(const TrianglePair& pair) {
  const auto longest = [](const std::array<Vec3, 3>& t) {
    return std::fmax((t[1] - t[0]).norm(), std::fmax((t[2] - t[1]).norm(), (t[0] - t[2]).norm()));
  };
  return std::fmin(longest(pair.a), longest(pair.b));
}

}  // namespace hapton
