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

// What a method felt along a trajectory, and what the reference says to it.
struct Evaluation {
  ForceError error;
  double shading = 0.0;  // of the method's force; the reference is never shaded, so what shading turns is part of the error
  std::vector<FeltStep> method, reference;
};

// Drives the method along the trajectory, contact forgotten where the trajectory says. Segments between those places are independent and
// run on `threads` threads, each with a method of its own.
Result<std::vector<FeltStep>> run_method(const MethodSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory,
                                         unsigned threads);

// Runs the method and the reference. The scene's first material gives the stiffness, its extent all lengths.
Result<Evaluation> evaluate_method(const EvaluationSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory);

// For people.
std::string to_text(const Evaluation& evaluation);

// One JSON object.
std::string to_json(const Evaluation& evaluation);

}  // namespace hapton
