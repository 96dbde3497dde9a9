#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/effects/surface_effects.h"
#include "core/force/touch_scene.h"

namespace hapton {

// Range of a value of a material: 0 to `most`, far beyond any surface and any device; it only rejects typing errors.
struct MaterialLimit {
  std::string_view key;  // the value's key in scene files
  double most = 0.0;
  bool above_zero = false;  // 0 itself is out of range
};

inline constexpr MaterialLimit kStiffnessLimit{"stiffness_n_per_m", 1e6, true};
inline constexpr MaterialLimit kDampingLimit{"damping_ns_per_m", 1e4, false};
inline constexpr MaterialLimit kFrictionStaticLimit{"friction_static", 10.0, false};
inline constexpr MaterialLimit kFrictionDynamicLimit{"friction_dynamic", 10.0, false};

// Error: "WHAT is VALUE: it must be ..." if the value is out of range. RT: no.
Result<void> check_number(const MaterialLimit& limit, std::string_view what, double value);

// Makes the checks of a scene file for an object whose material has changed. Error: one line with the object's name and the value that is
// out of range, inconsistent with another value, or without effect because of the surface's effects. `before`: the valid material from the
// scene file. RT: no.
Result<void> check_material(const Material& material, const Material& before, const SurfaceEffects& effects, std::string_view object);

}  // namespace hapton
