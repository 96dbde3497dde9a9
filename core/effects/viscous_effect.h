#pragma once

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"
#include "core/effects/effect_volume.h"

namespace hapton {

// A viscous volume: F = -b v, limited to a magnitude of max_force_n. Frame: S. Units: SI. RT: yes.
// Bound: max_force_n. Passivity: dissipative below max_force_n with the velocity of SmoothVelocity, if no interval is more than 16 times
// another, and with any velocity that has the direction of the motion.
struct ViscousEffect {
  static constexpr Passivity kPassivity = Passivity::dissipative;

  double damping_ns_per_m = 2.0;
  double max_force_n = 3.0;
  EffectVolume volume = EffectVolume::everywhere();

  double bound_n() const noexcept { return max_force_n; }
  Vec3 force(const EffectSample& sample) const noexcept {
    if (!volume.contains(sample.p_SD)) return Vec3::Zero();
    return bounded_force(-damping_ns_per_m * sample.v_SD, max_force_n);
  }
};

}  // namespace hapton
