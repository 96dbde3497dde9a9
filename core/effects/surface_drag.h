#pragma once

#include <algorithm>
#include <limits>

#include "core/effects/effect_sample.h"
#include "core/effects/spring_friction.h"

namespace hapton {

// Damping and friction of a material where the force method has neither (ForceMethod::unrendered_drag). Damping reduces the contact force f
// by b v, v the speed along the normal away from the surface, but the force never attracts: max(0, f - b v). Friction: SpringFriction.
// Units: SI. RT: yes. Bound: damping adds at most b times the speed of approach; friction adds at most the static coefficient times the
// contact force. Passivity: dissipative.
struct SurfaceDrag {
  static constexpr Passivity kPassivity = Passivity::dissipative;

  double damping_ns_per_m = 0.0;
  double stiffness_n_per_m = std::numeric_limits<double>::infinity();  // of the material; friction's spring is not stiffer
  SpringFriction::Coefficients friction = {};

  bool has_friction() const noexcept { return friction.at_rest > 0.0; }
  bool is_on() const noexcept { return damping_ns_per_m > 0.0 || has_friction(); }
  // pressed_n: the contact force without damping. leaving_m_per_s: speed of the device along the normal.
  double damped(double pressed_n, double leaving_m_per_s) const noexcept {
    return std::max(0.0, pressed_n - damping_ns_per_m * leaving_m_per_s);
  }
};

}  // namespace hapton
