#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/force/evaluation/force_error.h"
#include "core/force/force_method.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {

struct EvaluationSettings {
  MethodSettings method;
  int substeps = MethodSettings{}.reference_substeps;            // sub-steps of the reference in its first pass over a step
  int substep_limit = MethodSettings{}.reference_substep_limit;  // the reference does not double its sub-steps beyond this
  unsigned threads = 1;
};

// The output of a method along a trajectory, compared with the reference.
struct Evaluation {
  ForceError error;
  double shading = 0.0;  // of the method's force; the reference is never shaded, so the difference by shading is part of the error
  std::vector<ForceSample> method, reference;
};

// Runs the method along the trajectory, with resets where the trajectory has them. Segments between resets are independent and run on
// `threads` threads, each with its own method.
Result<std::vector<ForceSample>> run_method(const MethodSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory,
                                            unsigned threads);

// Runs the method and the reference. Stiffness: that of the scene's first material; extent: the longest side of the largest object.
Result<Evaluation> evaluate_method(const EvaluationSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory);

// Text for users.
std::string to_text(const Evaluation& evaluation);

// One JSON object.
std::string to_json(const Evaluation& evaluation);

}  // namespace hapton
