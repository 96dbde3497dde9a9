#include "core/force/stiffest.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/effects/mapped_spring.h"
#include "core/effects/tilted_spring.h"

namespace hapton {
namespace {

Stiffest stiffer_of(const Stiffest& a, const Stiffest& b) { return b.n_per_m > a.n_per_m ? b : a; }

bool has_image(const ImageMap& map, const SurfaceMaps& maps) { return map.is_on() && maps.triangles != nullptr; }

// The bumps of a surface, given by a formula or an image: the properties that make it stiff. Without is_on(), the surface is smooth.
struct Relief {
  const SurfaceBumps* bumps = nullptr;
  double slope = 0.0;
  double curvature_per_m = 0.0;

  // pressed_n: the force that presses the surface; for 0 the curvature is not needed.
  Relief(const SurfaceEffects& effects, double pressed_n) {
    const SurfaceMaps& maps = effects.maps;
    if (effects.bumps.is_on()) {
      bumps = &effects.bumps;
      slope = bumps->slope();
    } else if (has_image(maps.height, maps)) {
      slope = maps.height.steepest(*maps.triangles);
      if (pressed_n > 0.0) curvature_per_m = largest_curvature(maps.height, *maps.triangles);
    }
  }

  bool is_on() const { return bumps != nullptr || slope > 0.0; }
  double largest(double spring, double sideways, double pressed_n) const {
    if (bumps != nullptr) return largest_on_bumps(*bumps, spring, sideways, pressed_n);
    return TiltedSpring{.spring_n_per_m = spring,
                        .slope_squared = slope * slope,
                        .bending_n_per_m = pressed_n * curvature_per_m,
                        .sideways_n_per_m = sideways}
        .largest_n_per_m();
  }
};

// Friction has a spring along the surface, as stiff as the material's, where the method has none of its own or an image gives the
// coefficient.
double sideways_of(const Material& material, const SurfaceEffects& effects) {
  return effects.maps.friction.is_on() || material.friction_static > 0.0 ? material.stiffness_n_per_m : 0.0;
}

double progressive_of(const SurfaceEffects& effects) {
  return 2.0 * std::sqrt(kMaxPressedN * effects.progressive.n_per_m2);  // 2 c d, at the depth d at which the force c d^2 is kMaxPressedN
}

double stiffest_in_layers(const Relief& relief, const TissueLayers& layers, double sideways_n_per_m, double pressed_n) {
  double stiffest = 0.0;
  for (std::size_t i = 0; i < layers.count(); ++i)
    stiffest =
        std::max(stiffest, relief.largest(layers[i].stiffness_n_per_m, sideways_n_per_m, std::min(pressed_n, layers[i].pop_force_n)));
  return stiffest;
}

// The largest stiffness where the normal or the stiffness of a surface changes from place to place; 0: neither changes.
double stiffest_by_place(const Material& material, const SurfaceEffects& effects, double pressed_n) {
  const Relief relief(effects, pressed_n);
  const double sideways_n_per_m = sideways_of(material, effects);
  if (effects.layers.is_on()) return relief.is_on() ? stiffest_in_layers(relief, effects.layers, sideways_n_per_m, pressed_n) : 0.0;
  const double on_relief =
      relief.is_on() ? relief.largest(material.stiffness_n_per_m + progressive_of(effects), sideways_n_per_m, pressed_n) : 0.0;
  const SurfaceMaps& maps = effects.maps;
  if (!has_image(maps.stiffness, maps)) return on_relief;
  const MappedSpring spring{.spring_n_per_m = material.stiffness_n_per_m,
                            .beside_n_per_m = progressive_of(effects),
                            .sideways_n_per_m = sideways_n_per_m,
                            .pressed_n = pressed_n};
  if (!(pressed_n > 0.0)) return std::max({on_relief, spring.spring_n_per_m + spring.beside_n_per_m, sideways_n_per_m});
  if (!relief.is_on()) return spring.largest_n_per_m(maps.stiffness, *maps.triangles);
  return on_relief + spring.added_n_per_m(maps.stiffness, *maps.triangles, relief.slope);
}

struct SpaceGains {
  Stiffest stiffest = {};
  double viscosity_ns_per_m = 0.0;
};

// One overload for each type of effect, so that a new type has to say how stiff and how viscous it is.
struct SpaceGainsOf {
  SpaceGains operator()(const SpringEffect& spring) const { return {{spring.stiffness_n_per_m, StiffCause::spring_effect}}; }
  SpaceGains operator()(const SnapEffect& snap) const { return {{snap.stiffness_n_per_m(), StiffCause::snap_effect}}; }
  // Stiffest at the centre, where dx/dr is 1 / (sqrt(2) radius): its force is -max_force c x (1 + x^2)^(-3/2).
  SpaceGains operator()(const GravityWellEffect& well) const {
    const double c = 1.5 * std::sqrt(3.0);
    return {{well.max_force_n * c / (std::sqrt(2.0) * well.radius_m), StiffCause::gravity_well}};
  }
  // No function of the position, except for a step at the border of a volume; passivity() states the energy of that step.
  SpaceGains operator()(const ConstantEffect&) const { return {}; }
  SpaceGains operator()(const WaveEffect&) const { return {}; }
  SpaceGains operator()(const BurstEffect&) const { return {}; }
  // A function of the velocity only.
  SpaceGains operator()(const ViscousEffect& viscous) const { return {{}, viscous.damping_ns_per_m}; }
  // A mass has its own limit (find_stable_mass).
  SpaceGains operator()(const MassEffect&) const { return {}; }
};

LargestGains find_gains_in_space(const TouchScene& scene) {
  Stiffest stiffest;
  double most_ns_per_m = 0.0;
  for (const SwitchedEffect& one : scene.effects) {
    stiffest = stiffer_of(stiffest, stiffest_of(one.effect));
    most_ns_per_m = std::max(most_ns_per_m, viscosity_of(one.effect));
  }
  return {.stiffness_n_per_m = stiffest.n_per_m, .cause = stiffest.cause, .viscosity_ns_per_m = most_ns_per_m};
}

}  // namespace

Stiffest stiffest_spring_of(const Material& material, const SurfaceEffects& effects) {
  Stiffest stiffest{material.stiffness_n_per_m, effects.maps.stiffness.is_on() ? StiffCause::stiffness_map : StiffCause::spring};
  if (effects.layers.is_on()) stiffest = {0.0, StiffCause::layers};
  for (std::size_t i = 0; i < effects.layers.count(); ++i)
    stiffest.n_per_m = std::max(stiffest.n_per_m, effects.layers[i].stiffness_n_per_m);
  if (effects.progressive.is_on()) {
    stiffest.n_per_m += progressive_of(effects);
    stiffest.cause = StiffCause::progressive;
  }
  if (effects.snap.is_on()) stiffest = stiffer_of(stiffest, {effects.snap.stiffness_n_per_m, StiffCause::surface_snap});
  return stiffest;
}

Stiffest stiffest_by_place_of(const Material& material, const SurfaceEffects& effects, double pressed_n) {
  // Names all members, so that a new one has to be considered here, in stiffest_spring_of and in drag_of.
  [[maybe_unused]] const auto& [progressive, layers, bumps, viscosity, snap, tap, maps, texture, drag] = effects;
  const double n_per_m = stiffest_by_place(material, effects, pressed_n);
  if (!(n_per_m > 0.0)) return {};
  if (!has_image(maps.stiffness, maps)) return {n_per_m, StiffCause::bumps};
  SurfaceEffects alone = effects;
  alone.maps.stiffness.image = nullptr;
  return {n_per_m, 2.0 * stiffest_by_place(material, alone, pressed_n) >= n_per_m ? StiffCause::bumps : StiffCause::stiffness_map};
}

Stiffest stiffest_of(const SpaceEffect& effect) { return std::visit(SpaceGainsOf(), effect).stiffest; }

double find_stiffest_surface(const TouchScene& scene) {
  double stiffest_n_per_m = 0.0;
  for (const TouchObject& object : scene.objects)
    stiffest_n_per_m = std::max(stiffest_n_per_m, stiffest_spring_of(object.material, object.effects).n_per_m);
  return stiffest_n_per_m;
}

double viscosity_of(const SurfaceEffects& effects) {
  const ImageMap& map = effects.maps.viscosity;
  const double most_of_map = map.is_on() ? std::max(map.at_black, map.at_white) : 0.0;
  return std::max(effects.viscosity.damping_ns_per_m, most_of_map);
}

// A layer that is never punctured has no tissue behind it.
double drag_of(const SurfaceEffects& effects) {
  double drag_ns_per_m = 0.0;
  for (std::size_t i = 0; i < effects.layers.count(); ++i) {
    if (std::isfinite(effects.layers[i].pop_force_n)) drag_ns_per_m = std::max(drag_ns_per_m, effects.layers[i].drag_ns_per_m);
  }
  if (!(drag_ns_per_m > 0.0)) return 0.0;
  const Relief relief(effects, 0.0);
  return relief.is_on() ? relief.largest(drag_ns_per_m, viscosity_of(effects), 0.0) : drag_ns_per_m;
}

double viscosity_of(const SpaceEffect& effect) { return std::visit(SpaceGainsOf(), effect).viscosity_ns_per_m; }

// The stiffness is a convex function of the force that presses the surface, so below kMaxPressedN its chord is an upper bound. In layers it
// is not convex: there, what pressing adds counts in full.
double LargestGains::by_place_at(double pressed_n) const noexcept {
  const double share = std::clamp(pressed_n / kMaxPressedN, 0.0, 1.0);
  return by_place_n_per_m - (1.0 - share) * of_pressing_n_per_m;
}

LargestGains LargestGains::largest_of(const LargestGains& other) const noexcept {
  const double by_place = std::max(by_place_n_per_m, other.by_place_n_per_m);
  return {.stiffness_n_per_m = std::max(stiffness_n_per_m, other.stiffness_n_per_m),
          .cause = other.stiffness_n_per_m > stiffness_n_per_m ? other.cause : cause,
          .by_place_n_per_m = by_place,
          .of_pressing_n_per_m = by_place - std::max(by_place_at(0.0), other.by_place_at(0.0)),
          .place_cause = other.by_place_n_per_m > by_place_n_per_m ? other.place_cause : place_cause,
          .damping_ns_per_m = std::max(damping_ns_per_m, other.damping_ns_per_m),
          .viscosity_ns_per_m = std::max(viscosity_ns_per_m, other.viscosity_ns_per_m),
          .rotational_nm_per_rad = std::max(rotational_nm_per_rad, other.rotational_nm_per_rad)};
}

LargestGains find_largest_gains(const TouchScene& scene) {
  LargestGains gains = find_gains_in_space(scene);
  for (const TouchObject& object : scene.objects) {
    const Stiffest spring = stiffest_spring_of(object.material, object.effects);
    const Stiffest pressed = stiffest_by_place_of(object.material, object.effects);
    const Stiffest unpressed = pressed.n_per_m > 0.0 ? stiffest_by_place_of(object.material, object.effects, 0.0) : Stiffest();
    gains = gains.largest_of({.stiffness_n_per_m = spring.n_per_m,
                              .cause = spring.cause,
                              .by_place_n_per_m = pressed.n_per_m,
                              .of_pressing_n_per_m = object.effects.layers.is_on() ? 0.0 : pressed.n_per_m - unpressed.n_per_m,
                              .place_cause = pressed.cause,
                              .damping_ns_per_m = object.material.damping_ns_per_m,
                              .viscosity_ns_per_m = std::max(viscosity_of(object.effects), drag_of(object.effects))});
  }
  return gains;
}

LargestGains find_tool_gains(const TouchScene& scene) {
  LargestGains gains = find_gains_in_space(scene);
  for (const TouchObject& object : scene.objects) {
    const Stiffest spring = stiffest_spring_of(object.material, object.effects);
    gains = gains.largest_of({.stiffness_n_per_m = spring.n_per_m,
                              .cause = spring.cause,
                              .viscosity_ns_per_m = std::max(object.material.damping_ns_per_m, object.effects.viscosity.damping_ns_per_m)});
  }
  return gains;
}

}  // namespace hapton
