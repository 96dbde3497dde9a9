#include "core/force/moving_method.h"

#include <cmath>

namespace hapton {

Result<std::unique_ptr<ForceMethod>> MovingMethod::make(SceneParts::Make make, const MethodSettings& settings, const TouchScene& scene) {
  auto parts = SceneParts::make(make, settings, scene);
  if (!parts) return tl::unexpected(parts.error());
  return std::unique_ptr<ForceMethod>(new MovingMethod(std::move(*parts)));
}

MethodOutput MovingMethod::step(const MethodInput& input) noexcept {
  if (!input.p_SD.allFinite() || !std::isfinite(input.time_s)) return {.force_n = Vec3::Zero(), .p_SP = input.p_SD};
  parts_.begin(input);
  return proxy_.step(parts_, parts_.size(), parts_.has_still(), input.p_SD, input.dt_s);
}

}  // namespace hapton
