#pragma once

#include "core/force/touch_scene.h"

namespace hapton {

// The largest stiffness and damping that can act on the hand, for the warnings of too much of them; 0: none. RT: no.

// Of a surface: the spring or the layers, plus the progressive stiffness at 10 N of its progressive part; or the snap, if that is stiffer.
double stiffest_of(const Material& material, const SurfaceEffects& effects);
// Of a spring or a snap; other effects have no stiffness.
double stiffest_of(const SpaceEffect& effect);
// Of all surfaces of a scene, and of its effects in free space as well.
double find_stiffest_surface(const TouchScene& scene);
double find_stiffest(const TouchScene& scene);

// What a scene makes of position and velocity at most: the gains of the loop that the hand closes.
struct LargestGains {
  double stiffness_n_per_m = 0.0;   // find_stiffest
  double damping_ns_per_m = 0.0;    // of materials, with the velocity of the last interval
  double viscosity_ns_per_m = 0.0;  // of surfaces and in free space, with the velocity of SmoothVelocity, which lags more

  // Both at once: of what is used by turns.
  LargestGains largest_of(const LargestGains& other) const noexcept;
  bool any() const noexcept { return stiffness_n_per_m > 0.0 || damping_ns_per_m > 0.0 || viscosity_ns_per_m > 0.0; }
};
LargestGains find_largest_gains(const TouchScene& scene);
// With a rigid tool: its contacts have damping of materials and viscosity, but no images, and use the velocity of SmoothVelocity for both
// (contact_drag.h). So both are viscosity_ns_per_m.
LargestGains find_tool_gains(const TouchScene& scene);
// Of a surface, by a number or the largest of an image.
double viscosity_of(const SurfaceEffects& effects);
// In free space; effects that are not viscous have none.
double viscosity_of(const SpaceEffect& effect);

}  // namespace hapton
