#pragma once

#include <cmath>

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"

namespace hapton {

// Attraction by a soft ball of mass: F = -max_force c x / (1 + x^2)^(3/2) along the radius, with x = r / (sqrt(2) radius_m) and c = 3
// sqrt(3) / 2. The force is largest, max_force_n, at r = radius_m, falls with the square of the distance far away, and is zero at the
// centre. Frame: S. Units: SI. RT: yes. Bound: max_force_n. Passivity: conservative, as a central force that depends on the distance alone.
// Source: Plummer (1911), On the problem of distribution in globular star clusters; the scale is ours.
struct GravityWellEffect {
  static constexpr Passivity kPassivity = Passivity::conservative;

  Vec3 centre = Vec3::Zero();
  double radius_m = 0.02;  // > 0
  double max_force_n = 2.0;

  double bound_n() const noexcept { return max_force_n; }

  Vec3 force(const EffectSample& sample) const noexcept {
    const Vec3 x = (sample.p_SD - centre) / (std::sqrt(2.0) * radius_m);
    const double softened = 1.0 + x.squaredNorm();
    const double c = 1.5 * std::sqrt(3.0);
    return bounded_force((-max_force_n * c / (softened * std::sqrt(softened))) * x, max_force_n);
  }
};

}  // namespace hapton
