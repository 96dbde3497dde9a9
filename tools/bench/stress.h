#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/force/evaluation/stress_run.h"

namespace hapton {

// One variant of the stress test: how each body is placed, and its friction.
struct StressVariant {
  double scale = 1.0;
  double offset_extents = 0.0;  // distance from the origin, as a multiple of the body's longest side
  double friction_static = 0.0;
  double friction_dynamic = 0.0;
};

// The standard variants: each changes one of scale (1e-6 to 1e6), offset (up to a million extents) and friction.
std::vector<StressVariant> standard_variants();
// The variants for patches: without friction and with it. Scale and offset stay fixed: patches round the vertices to their own grid.
std::vector<StressVariant> patch_variants();

struct StressPlan {
  MethodSettings method;
  std::uint64_t seed = 1;
  std::uint64_t steps = 100000;  // for each body, divided among the variants; the last episode is finished, walks of 20,000 steps are added
  std::size_t compare_every = 64;  // steps between two comparisons with the reference; 0: only where a fault is suspected
  double probe_share = 0.0;        // above 0: radius of the probe for every body, as a share of its longest side, in place of its own
  bool by_patches = false;         // the force is computed on patches (patch_method.h); method proxy
  bool on_grid = false;            // the vertices are rounded to the grid of the patches, but the method gets the whole mesh
  bool no_seal = false;            // the cracks of mesh files are not sealed
  unsigned threads = 1;
  std::vector<StressVariant> variants = standard_variants();
};

// The counts of one body in one variant.
struct StressResult {
  std::string body;
  StressVariant variant;
  StressCount count;
};

// Runs every body in every variant on plan.threads threads; `progress` is called after each such run, by one thread at a time.
Result<std::vector<StressResult>> run_stress(const std::vector<StressBody>& bodies, const StressPlan& plan,
                                             const std::function<void(const StressResult&)>& progress);

// Runs only this episode, for every body and variant.
Result<std::vector<StressResult>> run_episode(const std::vector<StressBody>& bodies, const StressPlan& plan, std::uint64_t episode);

// A table for people with one line for each body, what its columns mean, and the findings, each with the command that reproduces it.
std::string to_text(const std::vector<StressResult>& results, const StressPlan& plan);
std::string to_json(const std::vector<StressResult>& results, const StressPlan& plan);

// Sum over all results.
StressCount sum_of(const std::vector<StressResult>& results);

}  // namespace hapton
