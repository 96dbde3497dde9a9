#pragma once

#include <cmath>
#include <utility>

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"
#include "core/effects/effect_volume.h"

namespace hapton {

// A virtual mass m that the hand tows through a damper of m / filter_s:
//
//   F = -m du/dt,   du/dt = (v - u) / filter_s,   u: the mass's own velocity
//
// which is -m times the acceleration behind a first-order low-pass of time constant filter_s. Differentiating positions twice would amplify
// noise, and any delay would make the loop unstable if m exceeds the mass of the device; the damper limits both. Below the frequency
// 1 / (2 pi filter_s) the effect feels like the mass, above it like the damper. In a volume the mass is at rest until the hand enters, and
// stays behind when the hand leaves. Frame: S. Units: SI. RT: yes.
// Bound: max_force_n, at which the damper slips.
// Passivity: dissipative below max_force_n, with the velocity of SmoothVelocity: for samples at equal intervals the damper's high-pass
// leads the velocity by 0 to 90 degrees at any frequency and the mean lags by 0 to 90 (the conjugate Fejér kernel is positive), so that
// the sum of F . motion is never positive. With the velocity of the last interval alone this holds for any intervals, and at the bound:
// F . motion is then the decrease of the energy m u^2 / 2, less what the damper takes. Stable ranges, with delay: docs/loop.md.
struct MassEffect {
  static constexpr Passivity kPassivity = Passivity::dissipative;
  // The damper is mass / filter_s: at this, 10 Ns/m for the default mass. A shorter filter would amplify the noise of positions.
  static constexpr double kMinFilterS = 0.005;

  // What is kept between two samples.
  struct State {
    Vec3 u = Vec3::Zero();        // velocity of the mass
    Vec3 force_n = Vec3::Zero();  // force at the last sample
    double time_s = 0.0;          // time of the last sample
  };

  double mass_kg = 0.05;
  double filter_s = 0.02;
  double max_force_n = 3.0;
  EffectVolume volume = EffectVolume::everywhere();

  double bound_n() const noexcept { return max_force_n; }

  // The force at the next sample. One that is no later than the sample before gives the same force again.
  Vec3 force(const EffectSample& sample, State& state) const noexcept {
    const double dt_s = sample.time_s - std::exchange(state.time_s, sample.time_s);
    if (!volume.contains(sample.p_SD)) {
      state.u = state.force_n = Vec3::Zero();
      return state.force_n;
    }
    if (!(dt_s > 0.0)) return state.force_n;
    const double share = -std::expm1(-dt_s / filter_s);
    state.force_n = bounded_force(-(mass_kg * share / dt_s) * (sample.v_SD - state.u), max_force_n);
    if (mass_kg > 0.0) state.u -= (dt_s / mass_kg) * state.force_n;
    return state.force_n;
  }
};

}  // namespace hapton
