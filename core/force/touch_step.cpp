#include "core/force/touch_step.h"

namespace hapton {
namespace {

// Assigned coefficient by coefficient, with no temporary on the way: it is stored as the method loads it, or a free step would wait for
// its own memory.
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
  const MethodOutput felt = method_->step(sample);
  TouchOutput output;
  output.contact = felt.contact;
  if (felt.contact) {
    output.force_n = input.X_WS.linear() * felt.force_n;
    output.visual_offset_m = input.X_WS.linear() * (felt.p_SP - sample.p_SD);
  }
  return output;
}

void TouchStep::reset(const TouchInput& input) noexcept { method_->reset(to_static_scene(input).p_SD); }

}  // namespace hapton
