#include "core/force/touch_step.h"

namespace hapton {

TouchOutput TouchStep::step(const TouchInput& input) noexcept {
  const Vec3 p_SD = input.X_WS.inverse() * input.p_WD;
  const MethodOutput felt = method_->step({.p_SD = p_SD, .dt_s = input.dt_s});
  TouchOutput output;
  output.contact = felt.contact;
  if (felt.contact) {
    output.force_n = input.X_WS.linear() * felt.force_n;
    output.visual_offset_m = input.X_WS.linear() * (felt.p_SP - p_SD);
  }
  return output;
}

void TouchStep::reset(const TouchInput& input) noexcept { method_->reset(input.X_WS.inverse() * input.p_WD); }

}  // namespace hapton
