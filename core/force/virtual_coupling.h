#pragma once

#include <cmath>

#include "core/force/touch_scene.h"

namespace hapton {

// A virtual coupling between device and probe: a spring in series with each surface's own, so that no material, however stiff, makes the
// loop stiffer than the coupling. Effects (core/effects) are not coupled: layers, snaps and progressive stiffness stay as stiff as they
// are. With a coupling that is passive for the device (closed_loop/passivity.h) every scene is: the probe has no mass, so the two springs
// are one (J. E. Colgate, M. C. Stanley, J. M. Brown, "Issues in the haptic display of tool use", IROS 1995; R. J. Adams, B. Hannaford,
// "Stable haptic interaction with virtual environments", IEEE Trans. Robotics and Automation 15, 1999). Units: SI. RT: couple_material yes;
// couple_scene set-up only.

// Stiffness K Kc / (K + Kc). Damping B (Kc / (K + Kc))^2: the spring-damper's share at speeds at which B v is small against the springs.
// coupling_n_per_m: above 0; 0 for none.
inline Material couple_material(Material material, double coupling_n_per_m) noexcept {
  if (!(coupling_n_per_m > 0.0) || !std::isfinite(coupling_n_per_m)) return material;
  // Without the product of two large stiffnesses, which might overflow.
  const double share = coupling_n_per_m / (material.stiffness_n_per_m + coupling_n_per_m);
  material.stiffness_n_per_m *= share;
  material.damping_ns_per_m *= share * share;
  return material;
}

// All materials of the scene; the meshes are shared.
inline TouchScene couple_scene(TouchScene scene, double coupling_n_per_m) {
  for (TouchObject& object : scene.objects) object.material = couple_material(object.material, coupling_n_per_m);
  return scene;
}

}  // namespace hapton
