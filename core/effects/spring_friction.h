#pragma once

#include "core/effects/effect_sample.h"

namespace hapton {

// Coulomb friction of a surface whose force method has none, or whose coefficient changes from place to place: a spring of the surface's
// stiffness between the device and a point that sticks to the surface, and slips when the spring is pulled beyond the cone:
//   extension = P(extension before + motion), force = -k extension,
// P the projection onto the disc of radius coefficient * normal force / k in the surface. While it slips the dynamic coefficient counts,
// until the pull is below kRestick times that radius; otherwise the static one. Frame: S. Units: SI. RT: yes.
//
// Bound: the static coefficient times the normal force. Passivity: dissipative if k does not grow. Whatever the disc, P shortens the pull
// or keeps it, so in every step extension . motion >= |extension|^2 / 2 - |extension before|^2 / 2: the hand gives at least what the spring
// stores.
// Source: return mapping of elastic-plastic friction (Wriggers, Computational Contact Mechanics, 2006, 5.2).
struct SpringFriction {
  static constexpr Passivity kPassivity = Passivity::dissipative;
  static constexpr double kRestick = 0.5;  // the same as for the friction of force methods (FrictionMotion)
  struct State {
    Vec3 extension = Vec3::Zero();  // from the point that sticks to the device, along the surface
    bool slips = false;
  };
  struct Coefficients {
    double at_rest = 0.0;
    double slipping = 0.0;  // at most at_rest
  };

  // motion: that of the device since the sample before. normal: unit. Pre: stiffness_n_per_m > 0; all others finite.
  static Vec3 force(const Vec3& motion, const Vec3& normal, double stiffness_n_per_m, double normal_n, const Coefficients& coefficient,
                    State& state) noexcept {
    const Vec3 to = state.extension + motion;
    state.extension = to - to.dot(normal) * normal;
    const double slipping_m = coefficient.slipping * normal_n / stiffness_n_per_m;
    const double most_m = state.slips ? slipping_m : coefficient.at_rest * normal_n / stiffness_n_per_m;
    const double length_m = state.extension.norm();
    if (length_m > most_m) {
      state.slips = true;
      state.extension *= slipping_m > 0.0 ? slipping_m / length_m : 0.0;
    } else if (length_m < kRestick * slipping_m) {
      state.slips = false;
    }
    return -stiffness_n_per_m * state.extension;
  }
};

}  // namespace hapton
