#pragma once

#include <cstdint>

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"
#include "closed_loop/passivity.h"
#include "closed_loop/stability.h"
#include "core/effects/mass_effect.h"

namespace hapton {

// The loop whose Z-width is computed: a device in a hand, against a wall that another node computes.
struct ZWidthCase {
  DeviceModel device;
  HandModel hand;
  double rate_hz = 1000.0;
  double delay_s = 0.0;                // from the sample to its force on the motors; the lag of the zero-order hold is added to it
  double wall_damping_ns_per_m = 0.0;  // damping of the wall by finite difference, besides the stiffness
  double mass_filter_s = MassEffect().filter_s;  // filter time of a virtual mass
};

// Largest stable and largest passive wall.
struct ZWidth {
  StabilityLimit stiffness;               // largest stable one, with the case's wall damping
  StabilityLimit damping_ns_per_m;        // largest stable damping of a wall without stiffness
  StabilityLimit viscosity_ns_per_m;      // largest stable viscosity of an effect without a wall
  StabilityLimit mass_kg;                 // largest stable virtual mass, without a wall
  PassiveStiffness passive;               // largest passive stiffness with any passive hand
  double passive_damping_ns_per_m = 0.0;  // largest passive damping of a wall without stiffness
  double linear_rule_n_per_m = 0.0;       // b / (T/2 + delay), with the damping of device and hand
};

// What the passivity of the case depends on.
PassivityCase make_passivity_case(const ZWidthCase& loop) noexcept;

// Exact for the linear loop (stability.h), with the exceptions in passivity.h. Pre: rate_hz, mass_filter_s and the masses of the device >
// 0, the rest >= 0. RT: no.
ZWidth find_zwidth(const ZWidthCase& loop);

}  // namespace hapton
