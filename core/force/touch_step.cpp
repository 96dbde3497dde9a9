#include "core/force/touch_step.h"

namespace hapton {
namespace {

Vec3 to_static_scene(const TouchInput& input) { return input.X_WS.linear().transpose() * (input.p_WD - input.X_WS.translation()); }

}  // namespace

TouchOutput TouchStep::step(const TouchInput& input) noexcept {
  const Vec3 p_SD = to_static_scene(input);
  const MethodOutput felt = method_->step({.p_SD = p_SD, .dt_s = input.dt_s});
  TouchOutput output;
  output.contact = felt.contact;
  if (felt.contact) {
    output.force_n = input.X_WS.linear() * felt.force_n;
    output.visual_offset_m = input.X_WS.linear() * (felt.p_SP - p_SD);
  }
  return output;
}

void TouchStep::reset(const TouchInput& input) noexcept { method_->reset(to_static_scene(input)); }

}  // namespace hapton
