#pragma once

#include <array>
#include <cstdint>

#include "core/math/types.h"

namespace hapton {

// The fixed directions of a hull with K planes: K / 2 axes, each with a lowest and a highest plane. The first three are those of an
// axis-aligned box; 14 adds the four through a cube's corners, 18 the six through its edges, 26 both. Axes have integer components and
// not unit length, so a projection is a sum of coordinates with little rounding. Source: FDH paper, section 5; Klosowski, Held,
// Mitchell, Sowizral & Zikan 1998 (k-DOPs).
template <int K>
struct FdhDirections {
  static_assert(K == 6 || K == 14 || K == 18 || K == 26, "hulls have 6, 14, 18 or 26 directions");
  static constexpr int kAxes = K / 2;

  using Axis = std::array<std::int8_t, 3>;

  static constexpr std::array<Axis, kAxes> kAxis = [] {
    constexpr std::array<Axis, 3> kBox = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    constexpr std::array<Axis, 4> kCorners = {{{1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}}};
    constexpr std::array<Axis, 6> kEdges = {{{1, 1, 0}, {1, -1, 0}, {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}}};
    std::array<Axis, kAxes> all{};
    int n = 0;
    for (const Axis& axis : kBox) all[n++] = axis;
    if (K == 14 || K == 26) {
      for (const Axis& axis : kCorners) all[n++] = axis;
    }
    if (K == 18 || K == 26) {
      for (const Axis& axis : kEdges) all[n++] = axis;
    }
    return all;
  }();

  // |axis|^2: 1, 2 or 3.
  static constexpr int length_squared(int axis) {
    const Axis& a = kAxis[axis];
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  }
};

// The projection of p on every axis (axis . p). RT: yes.
template <int K>
inline std::array<double, K / 2> fdh_project(const Vec3& p) {
  const double x = p.x();
  const double y = p.y();
  const double z = p.z();
  if constexpr (K == 6) {
    return {x, y, z};
  } else if constexpr (K == 14) {
    return {x, y, z, x + y + z, x + y - z, x - y + z, y + z - x};
  } else if constexpr (K == 18) {
    return {x, y, z, x + y, x - y, x + z, x - z, y + z, y - z};
  } else {
    return {x, y, z, x + y + z, x + y - z, x - y + z, y + z - x, x + y, x - y, x + z, x - z, y + z, y - z};
  }
}

// A hull in double precision: the points with projections from low[i] to high[i] on axis i. Empty until a point is added.
// Frame: any, the same for all points. RT: yes.
template <int K>
struct FdhHull {
  static constexpr int kAxes = K / 2;
  std::array<double, kAxes> low = filled(1.0);
  std::array<double, kAxes> high = filled(-1.0);

  void add(const Vec3& p) {
    const auto along = fdh_project<K>(p);
    for (int i = 0; i < kAxes; ++i) {
      low[i] = along[i] < low[i] ? along[i] : low[i];
      high[i] = along[i] > high[i] ? along[i] : high[i];
    }
  }

 private:
  static constexpr std::array<double, kAxes> filled(double sign) {
    std::array<double, kAxes> all{};
    for (double& value : all) value = sign * __builtin_huge_val();
    return all;
  }
};

}  // namespace hapton
