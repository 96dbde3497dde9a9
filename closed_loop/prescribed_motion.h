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
  double motor_j = 0.0;  // work of the motor force on the hand
  double lost_j = 0.0;   // heat in the device: viscous damping and friction
};

// The energies along the path from time 0 to its end and for `after_ns` more at rest. Pre: the chain has not been used before.
EnergyOfMotion measure_energy(ForceChain& chain, const DeviceModel& device, const HandPath& path, std::int64_t period_ns,
                              std::int64_t after_ns);

// The least stiffness of a wall at which some motion draws energy from device and wall together, and the name of that motion.
struct EnergyOnset {
  double stiffness_n_per_m = 0.0;
  std::string motion;
};

// Searches presses and releases, the worst motions of a frequency and its aliases where the delay is no multiple of the period (and at most
// 20 periods), and oscillations across an encoder edge. The motion is given, so the energy is linear in the stiffness: the onset is lost_j
// divided by the work of a wall of 1 N/m. This measurement checks find_passive_stiffness.
EnergyOnset find_energy_onset(const DeviceModel& device, std::int64_t period_ns, std::int64_t delay_ns);

// Force divided by position at one frequency, negated: for a spring its stiffness. Real part: rendered stiffness; imaginary part over 2 pi
// f: rendered damping, which delay and hold make negative. The device oscillates about bias_m with this amplitude: first at least one whole
// period and settle_ns to settle, then `cycles` periods that are measured. Pre: forces arrive before settle_ns is over.
std::complex<double> measure_rendered_stiffness(ForceChain& chain, std::int64_t period_ns, double frequency_hz, double bias_m,
                                                double amplitude_m, std::int64_t settle_ns, int cycles);

}  // namespace hapton
