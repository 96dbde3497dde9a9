#pragma once

#include <algorithm>

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"

namespace hapton {

// A film of liquid on a surface: F = -b v along the surface, v without its part along the contact normal. |F| is at most the contact force,
// so that the effect begins and ends with the contact without a force discontinuity. Frame: S. Units: SI. RT: yes.
// Bound: the contact force, and kMaxEffectForceN. Passivity: dissipative below the bound.
struct SurfaceViscosity {
  static constexpr Passivity kPassivity = Passivity::dissipative;

  double damping_ns_per_m = 0.0;  // 0: off

  bool is_on() const noexcept { return damping_ns_per_m > 0.0; }
  // normal: unit. contact_n: magnitude of the contact force.
  Vec3 force(const Vec3& v_SD, const Vec3& normal, double contact_n) const noexcept {
    const Vec3 along = v_SD - v_SD.dot(normal) * normal;
    return bounded_force(-damping_ns_per_m * along, std::min(contact_n, kMaxEffectForceN));
  }
};

}  // namespace hapton
