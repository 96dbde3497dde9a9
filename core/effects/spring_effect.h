#pragma once

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"

namespace hapton {

// A spring to a point: F = -k (p - c), limited to a magnitude of max_force_n. Frame: S. Units: SI. RT: yes.
// Bound: max_force_n. Passivity: conservative, as a central force that depends on the distance alone.
struct SpringEffect {
  static constexpr Passivity kPassivity = Passivity::conservative;

  Vec3 centre = Vec3::Zero();
  double stiffness_n_per_m = 100.0;
  double max_force_n = 3.0;

  double bound_n() const noexcept { return max_force_n; }
  Vec3 force(const EffectSample& sample) const noexcept { return bounded_force(-stiffness_n_per_m * (sample.p_SD - centre), max_force_n); }
};

}  // namespace hapton
