#pragma once

#include <string>

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"

namespace hapton {

// The stiffest and the most damped safe material of one system.
struct Recommendation {
  double stiffness_n_per_m = 0.0;   // the stiffest safe one
  double stable_n_per_m = 0.0;      // limit of stability, the least over all delays up to the given one
  double passive_n_per_m = 0.0;     // limit of passivity: below it no hand at all draws energy
  double damping_ns_per_m = 0.0;    // the most damped safe material
  double viscosity_ns_per_m = 0.0;  // the most viscous safe effect
  double device_n_per_m = 0.0;      // the stiffness stated for the device; 0: none
  bool is_limited_by_device = false;
};

// Half of the limit of stability (a gain margin of 2, 6 dB: masses and grips of people differ by as much), and no more than the device is
// known to hold. Of damping half of what is stable without stiffness: a material at both limits is stable as well. delay_s: from the sample
// to its force, at the slow end of what was measured. Pre: rate_hz > 0. RT: no.
constexpr double kGainMargin = 2.0;
Recommendation recommend_stiffness(const DeviceModel& device, const DeviceLimits& limits, const HandModel& hand, double rate_hz,
                                   double delay_s);

}  // namespace hapton
