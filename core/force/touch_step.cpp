#include "core/force/touch_step.h"

namespace hapton {
namespace {

// Written coefficient by coefficient without a temporary: the method loads the result at once, and a store of another width would stall
// that load (store forwarding).
MethodInput to_static_scene(const TouchInput& input) {
  MethodInput sample;
  const Vec3 from_origin = input.p_WD - input.X_WS.translation();
  sample.p_SD.noalias() = input.X_WS.linear().transpose().lazyProduct(from_origin);
  sample.dt_s = input.dt_s;
  return sample;
}

}  // namespace

TouchOutput TouchStep::step(const TouchInput& input) noexcept {
  const MethodInput sample = to_static_scene(input);
  const MethodOutput result = method_->step(sample);
  TouchOutput output;
  output.contact = result.contact;
  if (result.contact) {
    output.force_n = input.X_WS.linear() * result.force_n;
    output.visual_offset_m = input.X_WS.linear() * (result.p_SP - sample.p_SD);
  }
  return output;
}

void TouchStep::reset(const TouchInput& input) noexcept { method_->reset(to_static_scene(input).p_SD); }

}  // namespace hapton
