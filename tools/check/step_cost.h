#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/result.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// The time that a step of the force takes on this machine.
struct StepCost {
  std::size_t steps = 0;
  std::int64_t p99_ns = 0;
  std::int64_t worst_ns = 0;
  std::string worst_object;        // the object over which the worst step was
  Vec3 worst_at_m = Vec3::Zero();  // device point, frame S
};

struct StepCostSettings {
  double probe_radius_m = 0.0;
  double rate_hz = 1000.0;
  std::uint64_t seed = 1;
  std::size_t steps = 6000;  // in all; divided among the objects with the most triangles, but at least kMinSlideS for each
  std::size_t repeat = 3;    // runs; the least time of each step counts, because other work of the machine is not a cost of the scene
};
constexpr std::size_t kMaxSlideObjects = 12;  // only so many objects are touched, to bound the time of the check; a free choice
// The least duration of a slide: it begins with an approach of 0.2 s in free space.
constexpr double kMinSlideS = 1.0;
// A loop at a higher rate is measured at this rate, with longer steps.
constexpr double kMaxSlideHz = 10'000.0;

// Slides over the objects, one after the other, with the method of the live node (proxy) in the whole scene. Error: the method rejects the
// scene, or no triangle of an object has an area. RT: no.
Result<StepCost> measure_step_cost(const Scene& scene, const StepCostSettings& settings);

// Compares the cost with one cycle: the worst step has to fit into it, and 99 % of the steps into half of it (kStepShare); servo, link and
// operating system need the rest. RT: set-up only.
constexpr double kStepShare = 0.5;
CheckFindings check_cost(const StepCost& cost, double rate_hz);

}  // namespace hapton
