#pragma once

#include <cmath>

#include "core/force/touch_scene.h"

namespace hapton {

// A virtual coupling between device and probe: a spring in series with each surface's own, so that no material, however stiff, makes the
// loop stiffer than the coupling. Effects (core/effects) are not coupled: layers, snaps and progressive stiffness stay as stiff as they
// are. With a coupling that is passive for the device (closed_loop/passivity.h), so are the springs of all materials; their damping has a
// limit of its own (passive_damping_ns_per_m). The probe has no mass, so two springs act as one (J. E. Colgate, M. C. Stanley, J. M. Brown,
// "Issues in the haptic display of tool use", IROS 1995; R. J. Adams, B. Hannaford, "Stable haptic interaction with virtual environments",
// IEEE Trans. Robotics and Automation 15, 1999). Units: SI. RT: couple_material yes; couple_scene set-up only.

// The coupled material: stiffness K Kc / (K + Kc); damping B (Kc / (K + Kc))^2, for speeds v at which B v is small against the spring
// forces. coupling_n_per_m: Kc. Not above 0, or not finite: there is no coupling, and the material stays as it is.
inline Material couple_material(Material material, double coupling_n_per_m) noexcept {
  if (!(coupling_n_per_m > 0.0) || !std::isfinite(coupling_n_per_m)) return material;
  // Without the product of two large stiffnesses, which might overflow.
  const double share = coupling_n_per_m / (material.stiffness_n_per_m + coupling_n_per_m);
  material.stiffness_n_per_m *= share;
  material.damping_ns_per_m *= share * share;
  return material;
}

// Couples all materials of the scene; the copy shares the meshes.
inline TouchScene couple_scene(TouchScene scene, double coupling_n_per_m) {
  for (TouchObject& object : scene.objects) object.material = couple_material(object.material, coupling_n_per_m);
  return scene;
}

}  // namespace hapton
