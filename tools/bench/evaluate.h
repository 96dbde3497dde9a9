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
  int substeps = MethodSettings{}.reference_substeps;            // of the reference, to begin with
  int substep_limit = MethodSettings{}.reference_substep_limit;  // where it stops doubling them
  unsigned threads = 1;
};

// A method's output along a trajectory, and its comparison with the reference.
struct Evaluation {
  ForceError error;
  double shading = 0.0;  // of the method's force; the reference is never shaded, so what shading turns is part of the error
  std::vector<ForceSample> method, reference;
};

// Runs the method along the trajectory, with resets where the trajectory has them. Segments between resets are independent and run on
// `threads` threads, each with its own method.
Result<std::vector<ForceSample>> run_method(const MethodSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory,
                                            unsigned threads);

// Runs the method and the reference. The scene's first material gives the stiffness, its extent all lengths.
Result<Evaluation> evaluate_method(const EvaluationSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory);

// For people.
std::string to_text(const Evaluation& evaluation);

// One JSON object.
std::string to_json(const Evaluation& evaluation);

}  // namespace hapton
