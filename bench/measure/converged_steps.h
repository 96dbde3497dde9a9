#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "bench/measure/method_run.h"
#include "core/force/touch_step.h"

namespace hapton {

// Method forces without the work limit of a step (core/force/step_work.h), to tell what a method exerts while a step is not finished from
// what it exerts in another local minimum.
class ConvergedSteps {
 public:
  // Error: as make_method.
  static Result<ConvergedSteps> make(const MethodSettings& settings, const TouchScene& scene);

  struct Window {
    bool begins_sliding = false;    // at `start` the dynamic coefficient of friction applies (ProxyMethod::is_sliding); true if not known
    Vec3 begins_at = Vec3::Zero();  // where the device was when the proxy got where it is at `start`: on its way, if that step is carried
    std::vector<ForceSample> felt;
  };
  // Repeats the trajectory from the reset before `start` up to and including `start` exactly as the method runs it. Each of the next
  // `count` samples is stepped again until nothing of its motion is carried; the force is that of its last step. Pre: start + count <
  // trajectory rows, without a reset in between. RT: no.
  Window compute(const TouchTrajectory& trajectory, std::size_t start, std::size_t count);

 private:
  explicit ConvergedSteps(std::shared_ptr<ForceMethod> method, const TouchScene& scene) : method_(method), touch_(method, scene) {}

  std::shared_ptr<ForceMethod> method_;
  TouchStep touch_;
};

}  // namespace hapton
