#include "core/force/stiffest.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace hapton {

double stiffest_of(const Material& material, const SurfaceEffects& effects) {
  constexpr double kPressedN = 10.0;  // hardly any desktop device gives more
  double stiffest_n_per_m = effects.layers.is_on() ? 0.0 : material.stiffness_n_per_m;
  for (std::size_t i = 0; i < effects.layers.count(); ++i)
    stiffest_n_per_m = std::max(stiffest_n_per_m, effects.layers[i].stiffness_n_per_m);
  stiffest_n_per_m += 2.0 * std::sqrt(kPressedN * effects.progressive.n_per_m2);  // 2 c d where c d^2 is kPressedN
  return std::max(stiffest_n_per_m, effects.snap.is_on() ? effects.snap.stiffness_n_per_m : 0.0);
}

double stiffest_of(const SpaceEffect& effect) {
  if (const auto* spring = std::get_if<SpringEffect>(&effect)) return spring->stiffness_n_per_m;
  if (const auto* snap = std::get_if<SnapEffect>(&effect)) return snap->stiffness_n_per_m();
  return 0.0;
}

double find_stiffest_surface(const TouchScene& scene) {
  double stiffest_n_per_m = 0.0;
  for (const TouchObject& object : scene.objects)
    stiffest_n_per_m = std::max(stiffest_n_per_m, stiffest_of(object.material, object.effects));
  return stiffest_n_per_m;
}

double find_stiffest(const TouchScene& scene) {
  double stiffest_n_per_m = find_stiffest_surface(scene);
  for (const SwitchedEffect& one : scene.effects) stiffest_n_per_m = std::max(stiffest_n_per_m, stiffest_of(one.effect));
  return stiffest_n_per_m;
}

double viscosity_of(const SurfaceEffects& effects) {
  const ImageMap& map = effects.maps.viscosity;
  const double most_of_map = map.is_on() ? std::max(map.at_black, map.at_white) : 0.0;
  return std::max(effects.viscosity.damping_ns_per_m, most_of_map);
}

double viscosity_of(const SpaceEffect& effect) {
  const auto* viscous = std::get_if<ViscousEffect>(&effect);
  return viscous != nullptr ? viscous->damping_ns_per_m : 0.0;
}

LargestGains LargestGains::largest_of(const LargestGains& other) const noexcept {
  return {.stiffness_n_per_m = std::max(stiffness_n_per_m, other.stiffness_n_per_m),
          .damping_ns_per_m = std::max(damping_ns_per_m, other.damping_ns_per_m),
          .viscosity_ns_per_m = std::max(viscosity_ns_per_m, other.viscosity_ns_per_m)};
}

namespace {

double find_viscosity_in_space(const TouchScene& scene) {
  double most_ns_per_m = 0.0;
  for (const SwitchedEffect& one : scene.effects) most_ns_per_m = std::max(most_ns_per_m, viscosity_of(one.effect));
  return most_ns_per_m;
}

}  // namespace

LargestGains find_largest_gains(const TouchScene& scene) {
  LargestGains gains{.stiffness_n_per_m = find_stiffest(scene), .viscosity_ns_per_m = find_viscosity_in_space(scene)};
  for (const TouchObject& object : scene.objects) {
    gains.damping_ns_per_m = std::max(gains.damping_ns_per_m, object.material.damping_ns_per_m);
    gains.viscosity_ns_per_m = std::max(gains.viscosity_ns_per_m, viscosity_of(object.effects));
  }
  return gains;
}

LargestGains find_tool_gains(const TouchScene& scene) {
  LargestGains gains{.stiffness_n_per_m = find_stiffest(scene), .viscosity_ns_per_m = find_viscosity_in_space(scene)};
  for (const TouchObject& object : scene.objects) {
    gains.viscosity_ns_per_m =
        std::max({gains.viscosity_ns_per_m, object.material.damping_ns_per_m, object.effects.viscosity.damping_ns_per_m});
  }
  return gains;
}

}  // namespace hapton
