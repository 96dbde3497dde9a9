#pragma once

#include <string>

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"

namespace hapton {

// The stiffest and the most damped material that are safe on one system.
struct Recommendation {
  double stiffness_n_per_m = 0.0;   // stiffness of the stiffest safe material
  double stable_n_per_m = 0.0;      // limit of stability, the least over all delays from 0 to the given one
  double passive_n_per_m = 0.0;     // limit of passivity, the least likewise: below it no passive hand draws energy
  double damping_ns_per_m = 0.0;    // damping of the most damped safe material
  double viscosity_ns_per_m = 0.0;  // viscosity of the most viscous safe effect
  double device_n_per_m = 0.0;      // stiffness that the device is stated to hold; 0: none is stated
  bool is_limited_by_device = false;
};

// Recommends half of the limit of stability (a gain margin of 2, 6 dB: masses and grips of people differ by as much), but no more than the
// device is stated to hold; and half of the damping that is stable without stiffness: a material at both limits is stable as well. delay_s:
// from the sample to its force, at the slow end of what was measured. Pre: rate_hz > 0. RT: no.
constexpr double kGainMargin = 2.0;
Recommendation recommend_stiffness(const DeviceModel& device, const DeviceLimits& limits, const HandModel& hand, double rate_hz,
                                   double delay_s);

}  // namespace hapton
