#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "core/math/types.h"

namespace hapton {

// An axis-aligned box, empty until it is grown. Frame and units: those of its points. RT: yes.
struct Box {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void grow(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void grow(const Box& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  bool is_empty() const { return !(low.array() <= high.array()).all(); }
  Box inflated(double by) const { return {low.array() - by, high.array() + by}; }
  bool overlaps(const Box& other) const { return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all(); }
  Vec3 centre() const { return 0.5 * (low + high); }
  // The squared distance of p from the nearest point of the box; infinity for an empty box.
  double distance_squared(const Vec3& p) const { return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm(); }
  double diagonal() const { return (high - low).norm(); }

  static Box around(const Vec3& p, const Vec3& q) { return {p.cwiseMin(q), p.cwiseMax(q)}; }
  static Box around(const Vec3& a, const Vec3& b, const Vec3& c) { return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)}; }
  static Box of(std::span<const Vec3> points) {
    Box box;
    for (const Vec3& p : points) box.grow(p);
    return box;
  }
};

}  // namespace hapton
