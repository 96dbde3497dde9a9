#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/tool/tool_step.h"

namespace hapton {

// Force and torque on the device about the grip point. Frame S.
struct Wrench6 {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();
};

// A rigid tool, a scene and a motion of the device. `expected` is the wrench of frictionless contact and coupling, where it has a closed
// form or follows from the least energy of the coupling. The analytic scenarios are those of Weller, Sagardia et al., "A Benchmarking Suite
// for 6-DOF Real Time Collision Response Algorithms", 2010; the formulas are ours, each in a comment beside its scenario.
struct SixdofScenario {
  std::string name;
  std::shared_ptr<const TriangleMesh> tool;
  std::shared_ptr<const TriangleMesh> scene;
  ToolCoupling coupling;
  std::vector<Pose> device;                           // X_SD, one for each ms; the first is free of contact
  std::function<Wrench6(const Pose& X_SD)> expected;  // empty: none is known
};

// Box on plane, tilted box, cylinder in a V groove, peg in a slot, cone in cone, gear pair (gear_scenario.h): each has `expected`.
std::vector<SixdofScenario> make_analytic_scenarios(std::size_t steps);

// A square peg in a hole with 20 um of clearance on each side, pressed and turned at up to 100 mm/s and 2 rad/s; the seed draws the phases.
SixdofScenario make_peg_scenario(std::size_t steps, std::uint64_t seed);

// A bumpy ball of about tool_triangles slides and turns over a larger one of about scene_triangles.
SixdofScenario make_size_scenario(std::size_t tool_triangles, std::size_t scene_triangles, std::size_t steps, std::uint64_t seed);

}  // namespace hapton
