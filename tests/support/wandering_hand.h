#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "core/math/types.h"

namespace hapton {

// A hand that wanders at random over a ball of radius 31 mm around the origin, in and out by 4 mm. Frame: S. Units: m.
struct WanderingHand {
  explicit WanderingHand(std::uint64_t seed) : random(seed) {}

  const Vec3& next(double dt_s) {
    const Vec3 aim = (0.031 + 0.004 * std::sin(9.0 * time)) * p.normalized();
    velocity = 0.99 * velocity + Vec3(normal(random), normal(random), normal(random)) * 0.02 + 10.0 * (aim - p) * dt_s * 40.0;
    p += velocity * dt_s;
    time += dt_s;
    return p;
  }

  std::mt19937_64 random;
  std::normal_distribution<double> normal;
  Vec3 p = Vec3(0.01, 0.02, 0.035);
  Vec3 velocity = Vec3::Zero();
  double time = 0.0;
};

}  // namespace hapton
