#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "bench/measure/method_run.h"
#include "core/force/touch_step.h"

namespace hapton {

// Computes the forces of a method when every step is repeated until it converges. Comparing them with its ordinary forces tells errors of
// steps that ran out of work (core/force/step_work.h) from errors due to another local minimum.
class ConvergedSteps {
 public:
  // Error: that of make_method.
  static Result<ConvergedSteps> make(const MethodSettings& settings, const TouchScene& scene);

  struct Window {
    bool begins_sliding = false;  // at `start`: the dynamic coefficient of friction applies (ProxyMethod::is_sliding); true if not known
    // Device point for which the proxy is at its position at `start`, frame S (static scene), m: the sample itself, or a point before it on
    // the path of the device if the step ran out of work (ForceMethod::carried_from).
    Vec3 begins_at = Vec3::Zero();
    std::vector<ForceSample> felt;  // one for each of the `count` samples
  };
  // Runs the trajectory from the last reset at or before `start` up to and including `start`, one step a sample. Each of the next `count`
  // samples is then stepped until the step converges, at most 1025 times; its force is that of the last of these steps. Pre: start + count
  // < trajectory rows, without a reset in between. RT: no.
  Window compute(const TouchTrajectory& trajectory, std::size_t start, std::size_t count);

 private:
  explicit ConvergedSteps(std::shared_ptr<ForceMethod> method, const TouchScene& scene) : method_(method), touch_(method, scene) {}

  std::shared_ptr<ForceMethod> method_;
  TouchStep touch_;
};

}  // namespace hapton
