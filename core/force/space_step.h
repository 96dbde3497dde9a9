#pragma once

#include <utility>
#include <vector>

#include "core/effects/effect_step.h"
#include "core/force/touch_step.h"
#include "core/math/rigid_pose.h"

namespace hapton {

// The effects in free space of a scene, for a rigid tool that has no force method beside it (replay, Python). With a force method,
// TouchStep::step_in_space does the same. The effects act at the device point, the grip point of the tool. RT: step and reset yes.
class SpaceStep {
 public:
  explicit SpaceStep(std::vector<SwitchedEffect> effects) : effects_({}, std::move(effects)) {}

  // Force on the device, N, frame W. A sample that is not finite gives zero force and changes nothing.
  Vec3 step(const TouchInput& input) noexcept {
    if (!input.p_WD.allFinite()) return Vec3::Zero();
    if (X_WS_.matrix() != input.X_WS.matrix()) effects_.note_scene_moved(to_frame(input.X_WS, last_p_WD_));
    last_p_WD_ = input.p_WD;
    X_WS_ = input.X_WS;
    return input.X_WS.linear() * effects_.step_in_space(to_frame(input.X_WS, input.p_WD), input.dt_s, input.buttons);
  }
  void reset() noexcept { effects_.reset(); }

 private:
  EffectStep effects_;
  Vec3 last_p_WD_ = Vec3::Zero();  // device point and view transform of the last step
  Pose X_WS_ = Pose::Identity();
};

}  // namespace hapton
