#pragma once

#include <cstdint>

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"
#include "link/fault_injector.h"

namespace hapton {

// A linear loop over a link with random delay and loss.
struct RandomLoop {
  DeviceModel device = {};  // friction, encoder steps and saturation are left out: the loop is linear
  HandModel hand = {};
  std::int64_t period_ns = 1'000'000;
  LinkFaults to_law = {};
  LinkFaults from_law = {};
  double wall_damping_ns_per_m = 0.0;
  std::uint64_t seed = 1;
  double seconds = 20.0;  // simulated time for each stiffness; must be many times the delay
};

// The rate at which a motion grows, 1/s; negative: it dies out. Estimates the largest Lyapunov exponent from one simulated run. RT: no.
double measure_growth_per_s(const RandomLoop& loop, double stiffness_n_per_m);

// The stiffness at which growth begins, by bisection to 0.2 % with the same draws at every stiffness. It searches upwards from
// start_n_per_m, or downwards if that is unstable. Infinite: no limit was found; 0: it is unstable however small. RT: no.
double find_stable_stiffness_by_simulation(const RandomLoop& loop, double start_n_per_m);

// Finds likewise the limit of a wall with damping only, by finite difference of the samples that reach the force law;
// loop.wall_damping_ns_per_m is ignored. Infinite: no limit was found; 0: it is unstable however small. RT: no.
double find_stable_damping_by_simulation(const RandomLoop& loop, double start_ns_per_m);

// The mean delay of the force on the motors: its mean age since its sample, over loop.seconds, less half the period, for the hold. With a
// constant delay it is that delay; infinite if no force arrives. At a constant speed a spring lags by this much on average, so b / (T/2 +
// mean delay) is where slow presses begin to gain energy on average; a single press can gain some below it. RT: no.
double measure_mean_delay_s(const RandomLoop& loop);

}  // namespace hapton
