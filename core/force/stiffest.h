#pragma once

#include <cstdint>

#include "core/force/touch_scene.h"

namespace hapton {

// The largest stiffness and damping that can act on the hand, for the warnings of too much of them; 0: none. RT: no.

// What makes a surface, or an effect in free space, as stiff as it is.
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

// How hard a surface is pressed at most, where the device's largest force is not known: hardly any desktop device gives more.
constexpr double kMaxPressedN = 10.0;

// Of the springs of a surface: its own or the layers, plus the progressive stiffness at kMaxPressedN of its progressive part; or the snap,
// if that is stiffer.
Stiffest stiffest_spring_of(const Material& material, const SurfaceEffects& effects);
// Of a surface that is pressed with this force, where its normal or its stiffness changes from place to place (bumps, a stiffness map):
// what a hand feels that moves along it, with the springs (TiltedSpring, MappedSpring). None: they do not change.
Stiffest stiffest_by_place_of(const Material& material, const SurfaceEffects& effects, double pressed_n = kMaxPressedN);
// Of a spring, a snap or a gravity well, where it is stiffest; other effects have no stiffness.
Stiffest stiffest_of(const SpaceEffect& effect);
// Of all springs of the surfaces of a scene: of stiffest_spring_of.
double find_stiffest_surface(const TouchScene& scene);

// What a scene makes of position and velocity at most: the gains of the loop that the hand closes.
struct LargestGains {
  double stiffness_n_per_m = 0.0;  // of springs
  StiffCause cause = StiffCause::none;
  double by_place_n_per_m = 0.0;     // stiffest_by_place_of, pressed with kMaxPressedN
  double of_pressing_n_per_m = 0.0;  // the part of it that is due to the force; 0: not known
  StiffCause place_cause = StiffCause::none;
  double damping_ns_per_m = 0.0;       // of materials, with the velocity of the last interval
  double viscosity_ns_per_m = 0.0;     // of surfaces and in free space, with the velocity of SmoothVelocity, which lags more
  double rotational_nm_per_rad = 0.0;  // of the coupling of a rigid tool, which no scene has alone

  // By place, with less than kMaxPressedN: no less than that of any of the surfaces. With more, as with kMaxPressedN.
  double by_place_at(double pressed_n) const noexcept;
  // Both at once: of what is used by turns.
  LargestGains largest_of(const LargestGains& other) const noexcept;
  bool any() const noexcept {
    return stiffness_n_per_m > 0.0 || by_place_n_per_m > 0.0 || damping_ns_per_m > 0.0 || viscosity_ns_per_m > 0.0 ||
           rotational_nm_per_rad > 0.0;
  }
};
LargestGains find_largest_gains(const TouchScene& scene);
// With a rigid tool: its contacts have damping of materials and viscosity, but no images and no bumps, and use the velocity of
// SmoothVelocity for both (contact_damping.h). So both are viscosity_ns_per_m.
LargestGains find_tool_gains(const TouchScene& scene);
// Of a surface along it, by a number or the largest of an image.
double viscosity_of(const SurfaceEffects& effects);
// Of the layers of a surface, whose drag is viscous along the needle: with bumps and viscosity, of all of them. 0: no layer has any.
double drag_of(const SurfaceEffects& effects);
// In free space; effects that are not viscous have none.
double viscosity_of(const SpaceEffect& effect);

}  // namespace hapton
