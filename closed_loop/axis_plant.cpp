#include "closed_loop/axis_plant.h"

#include <numbers>

namespace hapton {

AxisPlant make_axis_plant(const DeviceModel& device, const HandModel& hand) {
  const int masses = device.mode_count + 1;
  AxisPlant plant;
  plant.has_amplifier = device.amplifier_hz > 0.0;
  const int states = 2 * masses + (plant.has_amplifier ? 1 : 0);
  plant.a.setZero(states, states);
  plant.b.setZero(states, AxisPlant::kInputs);
  for (int i = 0; i < masses; ++i) plant.a(2 * i, 2 * i + 1) = 1.0;

  // The mass that a force on mass i accelerates, whatever the force comes from.
  const auto mass_kg = [&](int i) {
    const double own = i == 0 ? device.motor_mass_kg() : device.modes[static_cast<std::size_t>(i - 1)].mass_kg;
    return i == masses - 1 ? own + hand.mass_kg : own;
  };
  plant.a(1, 1) -= device.damping_ns_per_m / mass_kg(0);
  for (int i = 0; i + 1 < masses; ++i) {
    const StructuralMode& mode = device.modes[static_cast<std::size_t>(i)];
    for (const auto& [here, there] : {std::pair(i, i + 1), std::pair(i + 1, i)}) {
      plant.a(2 * here + 1, 2 * here) -= mode.stiffness_n_per_m / mass_kg(here);
      plant.a(2 * here + 1, 2 * there) += mode.stiffness_n_per_m / mass_kg(here);
      plant.a(2 * here + 1, 2 * here + 1) -= mode.damping_ns_per_m / mass_kg(here);
      plant.a(2 * here + 1, 2 * there + 1) += mode.damping_ns_per_m / mass_kg(here);
    }
  }
  const int last = masses - 1;
  plant.a(2 * last + 1, 2 * last) -= hand.stiffness_n_per_m / mass_kg(last);
  plant.a(2 * last + 1, 2 * last + 1) -= hand.damping_ns_per_m / mass_kg(last);
  plant.b(2 * last + 1, AxisPlant::hand) = hand.stiffness_n_per_m / mass_kg(last);
  plant.b(2 * last + 1, AxisPlant::hand_speed) = hand.damping_ns_per_m / mass_kg(last);
  plant.b(1, AxisPlant::friction) = 1.0 / mass_kg(0);
  if (plant.has_amplifier) {
    const double rate = 2.0 * std::numbers::pi * device.amplifier_hz;
    plant.a(states - 1, states - 1) = -rate;
    plant.b(states - 1, AxisPlant::command) = rate;
    plant.a(1, states - 1) = 1.0 / mass_kg(0);
  } else {
    plant.b(1, AxisPlant::command) = 1.0 / mass_kg(0);
  }
  return plant;
}

}  // namespace hapton
