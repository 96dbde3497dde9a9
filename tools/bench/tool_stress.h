#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/force/evaluation/stress_body.h"
#include "core/tool/local_contacts.h"

namespace hapton {

struct ToolStressPlan {
  std::uint64_t seed = 1;
  std::uint64_t steps = 100'000;  // in all, at least; divided among bodies, tools, scales and frictions
  std::vector<double> scales = {1e-6, 1e-3, 1.0, 1e3, 1e6};
  // The friction of all surfaces; each value gets an equal share of the steps.
  std::vector<CoulombFriction> frictions = {{0.0, 0.0}, {0.8, 0.6}};
  bool moving = false;  // the body moves and turns, beside a ball that stands still
};

// The counts of all tools on one body. The first four are faults.
struct ToolStressCount {
  std::uint64_t penetrations = 0;  // a triangle of the tool intersects one of the scene (exact signs)
  std::uint64_t too_near = 0;      // tool and scene are nearer to each other than half the contact offset
  std::uint64_t not_finite = 0;    // a force, torque or placement is not finite
  std::uint64_t stuck = 0;         // steps are still blocked after the device has left the body
  std::uint64_t steps = 0;
  std::uint64_t contact_steps = 0;
  std::uint64_t unconverged = 0;  // the motion was continued in the next step: counted, not a fault
  std::uint64_t squeezed = 0;     // there was no room for the tool between the moving body and the ball: counted, not a fault
  std::uint64_t overlaps = 0;     // episodes that begin in an overlap
  std::string first_fault;        // tool, scale, friction and episode that reproduce it; empty: no fault

  std::uint64_t faults() const { return penetrations + too_near + not_finite + stuck; }
};

struct ToolStressResult {
  std::string body;
  ToolStressCount count;
};

// Six tools (ball, box, plate, wedge of 3 degrees, rod, bracket) are pressed on each body, slid, jittered and turned (up to 50 rad/s, plus
// jitter), at each scale, with each friction, from the seed. Every fourth episode begins near the body's middle, mostly in an overlap. With
// `moving` the body is checked at the pose for which the tool's force was computed. `progress` follows each body. Error: see ToolStep.
// RT: no.
Result<std::vector<ToolStressResult>> run_tool_stress(const std::vector<StressBody>& bodies, const ToolStressPlan& plan,
                                                      const std::function<void(const ToolStressResult&)>& progress);

// A table for people, and what its columns mean.
std::string to_text(const std::vector<ToolStressResult>& results);

}  // namespace hapton
