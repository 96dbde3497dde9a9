#pragma once

#include "closed_loop/sampled_plant.h"

namespace hapton {

// A wall as the program computes it: K x + B (x[k] - x[k-1]) / T.
struct WallGains {
  double stiffness_n_per_m = 0.0;
  double damping_ns_per_m = 0.0;
};

// The limit of stability, and the frequency of the oscillation there.
struct StabilityLimit {
  double value = 0.0;  // infinite: no limit was found
  double frequency_hz = 0.0;
};

// Stability of one axis against a wall: every eigenvalue of the exactly sampled loop within the unit circle. Linear: the wall pulls as well
// as it pushes, without quantisation, friction or saturation. Stability is not passivity (passivity.h).
//
// The limit is where, counted up from zero, an eigenvalue first reaches the unit circle. There 1 + (K + B (1 - 1/z) / T) L(z) = 0 with
// z = e^(j w T), so K follows from w: K(w) = -1/L - B (1 - 1/z) / T, wherever that is real and positive. The least such K is the limit,
// found without solving a matrix: the cost grows with the delay, not with its cube. Units SI. RT: no.

// The largest stiffness below which all are stable, with this damping in the wall. 0: not stable without stiffness. Pre: damping >= 0.
StabilityLimit find_stable_stiffness(const SampledPlant& plant, double damping_ns_per_m);
// The largest damping below which all are stable, with this stiffness. 0: not stable without damping.
StabilityLimit find_stable_damping(const SampledPlant& plant, double stiffness_n_per_m);
// The largest viscosity of an effect, without a wall, as EffectStep computes it at this rate: damping by the mean of eight differences,
// which lags more than the one difference of a wall (core/effects/smooth_velocity.h).
StabilityLimit find_stable_viscosity(const SampledPlant& plant);
// The largest virtual mass (core/effects/mass_effect.h) without a wall, in kg, as EffectStep computes it at this rate: behind the mean of
// eight differences. Pre: filter_s > 0.
StabilityLimit find_stable_mass(const SampledPlant& plant, double filter_s);

// Of the exactly sampled loop, delays among its states: 1 is the limit of stability. Takes the cube of the delay in periods.
double compute_spectral_radius(const SampledPlant& plant, const WallGains& wall);
// As find_stable_stiffness, by bisection over the spectral radius, between the last stable and the first unstable of K = start * growth^i.
double find_stable_stiffness_by_eigenvalues(const SampledPlant& plant, double damping_ns_per_m, double start_n_per_m, double growth);

}  // namespace hapton
