#pragma once

#include <algorithm>

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"

namespace hapton {

// A surface that grows stiffer as it is pressed in, like foam or skin: beside the spring of its material, F = c d^2 along the contact
// normal, d the penetration depth. The tangent stiffness grows by 2 c d. Units: SI. RT: yes. Bound: kMaxEffectForceN. Passivity:
// conservative without friction: the potential c d^3 / 3 depends on the depth alone.
struct ProgressiveStiffness {
  static constexpr Passivity kPassivity = Passivity::conservative;

  double n_per_m2 = 0.0;  // c; 0: off

  bool is_on() const noexcept { return n_per_m2 > 0.0; }
  static constexpr double bound_n() noexcept { return kMaxEffectForceN; }
  // depth_m >= 0.
  double force(double depth_m) const noexcept { return std::min(n_per_m2 * depth_m * depth_m, kMaxEffectForceN); }
};

}  // namespace hapton
