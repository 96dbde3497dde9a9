#pragma once

#include <memory>

#include "core/force/force_method.h"

namespace hapton {

// One device sample in the world frame, and the pose of the static scene.
struct TouchInput {
  Vec3 p_WD = Vec3::Zero();      // device point, m
  Pose X_WS = Pose::Identity();  // static scene in world (the view transform)
  double dt_s = 1e-3;
};

struct TouchOutput {
  Vec3 force_n = Vec3::Zero();          // acts on the device, frame W
  Vec3 visual_offset_m = Vec3::Zero();  // frame W: proxy minus device point; the probe is drawn at device point + this
  bool contact = false;
};

// One haptic step: transforms the device point into the static scene's frame, runs the method, and transforms force and visual offset back
// to the world. The live node, replay, tests and benches all call it. RT: step yes.
class TouchStep {
 public:
  explicit TouchStep(std::shared_ptr<ForceMethod> method) : method_(std::move(method)) {}

  TouchOutput step(const TouchInput& input) noexcept;
  void reset(const TouchInput& input) noexcept;
  const ForceMethod& method() const { return *method_; }
  // Shared with the slow task, which calls prepare() beside step().
  std::shared_ptr<ForceMethod> share_method() const { return method_; }

 private:
  std::shared_ptr<ForceMethod> method_;
};

}  // namespace hapton
