#pragma once

#include "closed_loop/sampled_plant.h"

namespace hapton {

// The gains of a wall whose force the program computes as K x + B (x[k] - x[k-1]) / T.
struct WallGains {
  double stiffness_n_per_m = 0.0;
  double damping_ns_per_m = 0.0;
};

// The limit of stability, and the frequency of the oscillation there.
struct StabilityLimit {
  double value = 0.0;  // infinite: no limit was found
  double frequency_hz = 0.0;
};

// Stability of one axis against a wall: every eigenvalue of the exactly sampled loop is within the unit circle. The loop is linear: the
// wall pulls as well as it pushes, without quantisation, friction or saturation. Stability is not passivity (passivity.h).
//
// The limit is the least gain, from zero upwards, at which an eigenvalue reaches the unit circle. At this gain 1 + (K + B (1 - 1/z) / T)
// L(z) = 0 with z = e^(j w T), so K follows from w: K(w) = -1/L - B (1 - 1/z) / T, wherever that is real and positive. The least such K is
// the limit, found without solving a matrix: the cost grows with the delay, not with its cube. Units SI. RT: no.

// The stiffness below which every stiffness is stable with this damping in the wall. 0: not stable without stiffness. Pre: damping >= 0.
StabilityLimit find_stable_stiffness(const SampledPlant& plant, double damping_ns_per_m);
// The damping below which every damping is stable with this stiffness. 0: not stable without damping. Pre: stiffness >= 0.
StabilityLimit find_stable_damping(const SampledPlant& plant, double stiffness_n_per_m);
// The largest stable viscosity of an effect, without a wall, as EffectStep computes it at this rate: damping by the mean of eight
// differences, which lags more than the one difference of a wall (core/effects/smooth_velocity.h).
StabilityLimit find_stable_viscosity(const SampledPlant& plant);
// The largest stable virtual mass (core/effects/mass_effect.h) without a wall, in kg, as EffectStep computes it at this rate: after the
// mean of eight differences. Pre: filter_s > 0.
StabilityLimit find_stable_mass(const SampledPlant& plant, double filter_s);

// The largest magnitude of an eigenvalue of the exactly sampled loop; 1: limit of stability. Cost: the cube of the delay in periods.
double compute_spectral_radius(const SampledPlant& plant, const WallGains& wall);
// The limit of find_stable_stiffness, found by bisection over the spectral radius from K = start * growth^i, the last stable and the next.
double find_stable_stiffness_by_eigenvalues(const SampledPlant& plant, double damping_ns_per_m, double start_n_per_m, double growth);

}  // namespace hapton
