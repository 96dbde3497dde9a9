#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/result.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// What a step of the force takes on this machine.
struct StepCost {
  std::size_t steps = 0;
  std::int64_t p99_ns = 0;
  std::int64_t worst_ns = 0;
  std::string worst_object;        // over which it was
  Vec3 worst_at_m = Vec3::Zero();  // device point, frame S
};

struct StepCostSettings {
  double probe_radius_m = 0.0;
  double rate_hz = 1000.0;
  std::uint64_t seed = 1;
  std::size_t steps = 6000;  // of all objects together; each of the largest kMaxSlideObjects has its share, at least kMinSlideS
  std::size_t repeat = 3;    // the least time of each step counts: what else the machine does is not a cost of the scene
};
constexpr std::size_t kMaxSlideObjects = 12;  // the largest objects stand for all, to bound the time of the check; a free choice
// A slide begins with an approach of 0.2 s in free space.
constexpr double kMinSlideS = 1.0;
// A faster loop is measured with the steps of this one, which are longer.
constexpr double kMaxSlideHz = 10'000.0;

// Slides over the objects, one after the other, by the method of the live node (proxy) in the whole scene. Error: the method's, for a scene
// that it rejects. RT: no.
Result<StepCost> measure_step_cost(const Scene& scene, const StepCostSettings& settings);

// The cost against one cycle: the worst step has to fit in it, and 99 % in half of it; servo, link and operating system have the rest.
// RT: set-up only.
constexpr double kStepShare = 0.5;
CheckFindings check_cost(const StepCost& cost, double rate_hz);

}  // namespace hapton
