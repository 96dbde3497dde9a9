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
  std::uint64_t steps = 100'000;  // in all, at least; shared by bodies, tools and scales
  std::vector<double> scales = {1e-6, 1e-3, 1.0, 1e3, 1e6};
  // Of all surfaces; each has its share of the steps.
  std::vector<CoulombFriction> frictions = {{0.0, 0.0}, {0.8, 0.6}};
  bool moving = false;  // the body moves and turns, beside a ball that stands still
};

// What a tool went through on one body. Faults are the first four.
struct ToolStressCount {
  std::uint64_t penetrations = 0;  // a triangle of the tool intersects one of the scene (exact signs)
  std::uint64_t too_near = 0;      // nearer than half the contact offset
  std::uint64_t not_finite = 0;    // a force, torque or placement
  std::uint64_t stuck = 0;         // an overlap at the start still blocks after the device has left
  std::uint64_t steps = 0;
  std::uint64_t contact = 0;
  std::uint64_t unconverged = 0;  // carried on in the next step: counted, not a fault
  std::uint64_t squeezed = 0;     // between the body that moves and the ball there was no room: counted, not a fault
  std::uint64_t overlaps = 0;     // episodes that begin in an overlap
  std::string first_fault;        // where it is found again; empty: none

  std::uint64_t faults() const { return penetrations + too_near + not_finite + stuck; }
};

struct ToolStressResult {
  std::string body;
  ToolStressCount count;
};

// Seeded tools (ball, box, plate, wedge of 3 degrees, rod, bracket) pressed, slid, jittered and turned at up to 50 rad/s on each body, at
// each scale, with each friction; every fourth episode begins in an overlap. With `moving` the body is part of the walk, and is checked
// where the tool feels it. `progress` is called after each body. Error: see ToolStep::make. RT: no.
Result<std::vector<ToolStressResult>> run_tool_stress(const std::vector<StressBody>& bodies, const ToolStressPlan& plan,
                                                      const std::function<void(const ToolStressResult&)>& progress);

// A table for people and what its columns mean.
std::string to_text(const std::vector<ToolStressResult>& results);

}  // namespace hapton
