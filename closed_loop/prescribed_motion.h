#pragma once

#include <complex>
#include <cstdint>
#include <string>

#include "closed_loop/device_model.h"
#include "closed_loop/force_chain.h"
#include "closed_loop/hand_path.h"

namespace hapton {

// The device moved by a hand so strong that no force changes its motion: the worst case of a passive hand. All integrals are exact, since
// the force is constant between two events and the motion is straight between two points of the path. One axis, x; the amplifier has no lag
// here. Units SI, ns. RT: no.

struct EnergyOfMotion {
  double motor_j = 0.0;  // work of the force on the hand
  double lost_j = 0.0;   // heat in the device: viscous damping and friction
};

// Along the path from 0 to its end and `after_ns` longer, at rest there.
EnergyOfMotion measure_energy(ForceChain& chain, const DeviceModel& device, const HandPath& path, std::int64_t period_ns,
                              std::int64_t after_ns);

// The least stiffness of a wall at which some motion draws energy from device and wall together, and which motion that is.
struct EnergyOnset {
  double stiffness_n_per_m = 0.0;
  std::string motion;
};

// Searched over presses and releases, over the worst motions of a frequency and its aliases where the delay is not a multiple of the
// period, and over oscillations across an encoder edge. The motion is given, so the energy is linear in the stiffness: the onset is lost_j
// divided by the work of a wall of 1 N/m. This measurement checks find_passive_stiffness.
EnergyOnset find_energy_onset(const DeviceModel& device, std::int64_t period_ns, std::int64_t delay_ns);

// Force over position at one frequency, negated: for a spring its stiffness. Real part: rendered stiffness; imaginary part over 2 pi f:
// rendered damping, which delay and hold make negative. The device oscillates about bias_m with this amplitude: whole periods to settle,
// one at least and settle_ns together, then `cycles` periods that are measured. Pre: by settle_ns forces arrive.
std::complex<double> measure_rendered_stiffness(ForceChain& chain, std::int64_t period_ns, double frequency_hz, double bias_m,
                                                double amplitude_m, std::int64_t settle_ns, int cycles);

}  // namespace hapton
