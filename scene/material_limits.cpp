#include "scene/material_limits.h"

#include <fmt/core.h>

#include "scene/text_cursor.h"

namespace hapton {

Result<void> check_number(const MaterialLimit& limit, std::string_view what, double value) {
  const bool holds = value >= 0.0 && value <= limit.most && !(limit.above_zero && value == 0.0);
  if (holds) return {};
  return fail("{} is {}: it must be {} 0 and at most {}", what, value, limit.above_zero ? "above" : "at least", limit.most);
}

Result<void> check_material(const Material& material, const Material& before, const SurfaceEffects& effects, std::string_view object) {
  const struct {
    const MaterialLimit& limit;
    double value;
  } numbers[] = {{kStiffnessLimit, material.stiffness_n_per_m},
                 {kDampingLimit, material.damping_ns_per_m},
                 {kFrictionStaticLimit, material.friction_static},
                 {kFrictionDynamicLimit, material.friction_dynamic}};
  for (const auto& [limit, value] : numbers) {
    const auto fits = check_number(limit, fmt::format("'{}' of object '{}'", limit.key, printable(object)), value);
    if (!fits) return fits;
  }
  if (material.friction_dynamic > material.friction_static) {
    return fail("'friction_dynamic' of object '{}' is {}, more than 'friction_static' {}: make it at most that", printable(object),
                material.friction_dynamic, material.friction_static);
  }
  if (effects.layers.is_on() &&
      (material.stiffness_n_per_m != before.stiffness_n_per_m || material.damping_ns_per_m != before.damping_ns_per_m)) {
    return fail("object '{}' has layers, which replace 'stiffness_n_per_m' and 'damping_ns_per_m': change them in the scene file",
                printable(object));
  }
  const bool has_relief = effects.bumps.is_on() || effects.maps.height.is_on() || effects.maps.stiffness.is_on();
  if (effects.maps.friction.is_on() && material.friction_static > 0.0) {
    return fail("object '{}' has a friction map instead of friction coefficients: change the map in the scene file", printable(object));
  }
  if (has_relief && material.damping_ns_per_m > 0.0) {
    return fail("object '{}' has bumps or a stiffness map, which would turn 'damping_ns_per_m' = {} into a source of energy: leave it at 0",
                printable(object), material.damping_ns_per_m);
  }
  return {};
}

}  // namespace hapton
