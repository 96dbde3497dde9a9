#pragma once

#include <cstdint>

#include "core/force/touch_scene.h"

namespace hapton {

// The largest stiffness and damping that can act on the hand, for warnings that they are too large; 0: none. Units: SI. RT: no.

// The cause of the largest stiffness of a surface or of an effect in free space.
enum class StiffCause : std::uint8_t {
  none,
  spring,
  stiffness_map,
  progressive,
  layers,
  surface_snap,
  bumps,
  spring_effect,
  snap_effect,
  gravity_well
};

struct Stiffest {
  double n_per_m = 0.0;
  StiffCause cause = StiffCause::none;
};

// The largest force with which a surface is pressed, where that of the device is not known: hardly any desktop device gives more.
constexpr double kMaxPressedN = 10.0;

// The largest stiffness of the springs of a surface: its material or its layers, plus the progressive stiffness where the progressive force
// is kMaxPressedN; or its snap, if that is stiffer.
Stiffest stiffest_spring_of(const Material& material, const SurfaceEffects& effects);
// The largest stiffness, springs included, that a hand feels which moves along a surface and presses it with this force, where bumps or a
// stiffness map change normal or stiffness from place to place (TiltedSpring, MappedSpring). 0, StiffCause::none: neither changes.
Stiffest stiffest_by_place_of(const Material& material, const SurfaceEffects& effects, double pressed_n = kMaxPressedN);
// The largest stiffness of a spring, a snap or a gravity well, at the place where it is stiffest; 0 for other effects.
Stiffest stiffest_of(const SpaceEffect& effect);
// The largest stiffness by stiffest_spring_of() of all surfaces of a scene, N/m.
double find_stiffest_surface(const TouchScene& scene);

// The largest gains from position and velocity to force in a scene: those of the loop that the hand closes.
struct LargestGains {
  double stiffness_n_per_m = 0.0;  // of springs, on surfaces and in free space
  StiffCause cause = StiffCause::none;
  double by_place_n_per_m = 0.0;     // by stiffest_by_place_of, pressed with kMaxPressedN
  double of_pressing_n_per_m = 0.0;  // the part of by_place_n_per_m that the force causes; 0: not known
  StiffCause place_cause = StiffCause::none;
  double damping_ns_per_m = 0.0;       // of materials, which use the velocity of the last interval
  double viscosity_ns_per_m = 0.0;     // on surfaces and in free space, with the velocity of SmoothVelocity, which lags more
  double rotational_nm_per_rad = 0.0;  // of the coupling of a rigid tool; find_*_gains leave it 0

  // Upper bound of stiffest_by_place_of for this force, over all surfaces. Above kMaxPressedN: the value for kMaxPressedN.
  double by_place_at(double pressed_n) const noexcept;
  // The larger value of each gain, for two scenes or objects of which either may act.
  LargestGains largest_of(const LargestGains& other) const noexcept;
  bool any() const noexcept {
    return stiffness_n_per_m > 0.0 || by_place_n_per_m > 0.0 || damping_ns_per_m > 0.0 || viscosity_ns_per_m > 0.0 ||
           rotational_nm_per_rad > 0.0;
  }
};
LargestGains find_largest_gains(const TouchScene& scene);
// The same with a rigid tool: its contacts have the damping of materials and viscosity, but no images and no bumps, and use the velocity of
// SmoothVelocity for both (contact_damping.h). So both count in viscosity_ns_per_m, and damping_ns_per_m is 0.
LargestGains find_tool_gains(const TouchScene& scene);
// The viscosity of a surface for motion along it, N s/m: the larger of its number and the largest value of its image.
double viscosity_of(const SurfaceEffects& effects);
// The largest viscous drag along the needle in the layers of a surface, N s/m; on bumps, with the viscosity. 0: no layer has any.
double drag_of(const SurfaceEffects& effects);
// The viscosity of an effect in free space, N s/m; 0 for effects that are not viscous.
double viscosity_of(const SpaceEffect& effect);

}  // namespace hapton
