#pragma once

#include "core/effects/effect_sample.h"

namespace hapton {

// Coulomb friction whose coefficient changes from place to place: a spring of the surface's stiffness between the device and a point that
// sticks to the surface, and slips when the spring is pulled beyond the cone:
//   pulled = P(pulled before + motion), force = -k pulled,
// P the projection onto the disc of radius coefficient * normal force / k in the surface. Frame: S. Units: SI. RT: yes.
//
// Bound: coefficient times the normal force. Passivity: dissipative. The disc contains 0 and P is the projection onto it, so in every step
// pulled . motion >= |pulled|^2 / 2 - |pulled before|^2 / 2: the hand gives at least what the spring stores. Source: return mapping of
// elastic-plastic friction (Wriggers, Computational Contact Mechanics, 2006, 5.2).
struct MapFriction {
  static constexpr Passivity kPassivity = Passivity::dissipative;
  struct State {
    Vec3 pulled = Vec3::Zero();  // the device beyond the point that sticks, along the surface
  };

  // motion: of the device since the sample before. normal: unit. Pre: stiffness_n_per_m > 0; the others finite.
  static Vec3 force(const Vec3& motion, const Vec3& normal, double stiffness_n_per_m, double normal_n, double coefficient,
                    State& state) noexcept {
    const Vec3 to = state.pulled + motion;
    state.pulled = to - to.dot(normal) * normal;
    const double most_m = coefficient * normal_n / stiffness_n_per_m;
    const double length_m = state.pulled.norm();
    if (length_m > most_m) state.pulled *= most_m > 0.0 ? most_m / length_m : 0.0;
    return -stiffness_n_per_m * state.pulled;
  }
};

}  // namespace hapton
