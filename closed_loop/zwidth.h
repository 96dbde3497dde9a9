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
  double delay_s = 0.0;                          // from the sample to its force on the motors; the hold comes on top
  double wall_damping_ns_per_m = 0.0;            // by finite difference, beside the stiffness
  double mass_filter_s = MassEffect().filter_s;  // of a virtual mass
};

// Largest stable and largest passive wall.
struct ZWidth {
  StabilityLimit stiffness;               // stable, with the case's wall damping
  StabilityLimit damping_ns_per_m;        // stable, without stiffness
  StabilityLimit viscosity_ns_per_m;      // stable, of an effect without a wall
  StabilityLimit mass_kg;                 // stable virtual mass, without a wall
  PassiveStiffness passive;               // whatever passive hand holds the device
  double passive_damping_ns_per_m = 0.0;  // without stiffness
  double linear_rule_n_per_m = 0.0;       // b / (T/2 + delay), with the damping of device and hand
};

// What the passivity of the case depends on.
PassivityCase make_passivity_case(const ZWidthCase& loop) noexcept;

// Exact for the linear loop (stability.h), except as passivity.h says. Pre: rate_hz, mass_filter_s and the masses of the device > 0, the
// rest >= 0. RT: no.
ZWidth find_zwidth(const ZWidthCase& loop);

}  // namespace hapton
