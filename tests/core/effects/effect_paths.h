#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "core/math/types.h"

// Seeded closed paths, and the work of a force along them.
namespace hapton::paths {

// A smooth closed path of n points around `centre`, at most `extent` away along each axis: the sum of three waves along each axis, with
// random amplitudes and phases.
inline std::vector<Vec3> closed(std::uint64_t seed, int n, const Vec3& centre, double extent) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Vec3 amplitude[3], phase[3];
  for (int k = 0; k < 3; ++k) {
    amplitude[k] = Vec3(unit(random), unit(random), unit(random)) * (extent / 3.0);
    phase[k] = Vec3(unit(random), unit(random), unit(random)) * std::numbers::pi;
  }
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / n;
    Vec3 p = centre;
    for (int k = 0; k < 3; ++k) p += amplitude[k].cwiseProduct((Vec3::Constant((k + 1) * angle) + phase[k]).array().sin().matrix());
    points.push_back(p);
  }
  return points;
}

// Work done on the hand along a closed path, by the trapezoidal rule, and the sum of the absolute values of its pieces.
struct Work {
  double net_j = 0.0;
  double absolute_j = 0.0;
};

// The work of a force along a path. force_at(p): the force, which depends on the position alone.
template <class ForceAt>
Work work_along(const std::vector<Vec3>& path, const ForceAt& force_at) {
  Work work;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3& a = path[i];
    const Vec3& b = path[(i + 1) % path.size()];
    const double piece = 0.5 * (force_at(a) + force_at(b)).dot(b - a);
    work.net_j += piece;
    work.absolute_j += std::abs(piece);
  }
  return work;
}

}  // namespace hapton::paths
