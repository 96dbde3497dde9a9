#pragma once

#include "core/math/types.h"

namespace hapton {

// A proxy held on a plane by Coulomb friction while the device moves straight at constant speed.
struct FrictionMotion {
  Vec3 lag = Vec3::Zero();      // device minus proxy at the start, in the plane
  Vec3 motion = Vec3::Zero();   // of the device, in the plane
  double pressure_start = 0.0;  // normal distance between proxy and device: the normal force without its stiffness; > 0
  double pressure_end = 0.0;    // > 0; it changes linearly on the way
  double friction_static = 0.0;
  double friction_dynamic = 0.0;  // <= friction_static
  bool sliding = false;           // at the start
};

struct FrictionDrag {
  Vec3 lag = Vec3::Zero();  // device minus proxy at the end, in the plane
  bool sliding = false;     // at the end
};

// Follows the proxy to the end of the motion, in closed form: it sticks until the lag leaves the static cone, jumps to the dynamic one, and
// is then dragged along its own lag, which keeps the cone's size. That path is the tractrix: with the angle psi between lag and motion and
// the cone's radius R, R psi' = -|motion| sin psi, so tan(psi / 2) falls by exp(-integral of |motion| / R). It sticks again where the lag
// would become shorter than the cone is wide. This is the limit of ever finer steps of return mapping (the play operator in the plane). All
// lengths in one unit; only their ratios matter. RT: yes. Source: Visintin, Differential Models of Hysteresis (1994), III.2, vector play;
// the tractrix with a linear radius is ours.
FrictionDrag drag_by_friction(const FrictionMotion& input) noexcept;

}  // namespace hapton
