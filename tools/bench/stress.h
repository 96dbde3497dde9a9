#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/force/evaluation/stress_run.h"

namespace hapton {

// The placement and material of a stress test of every body.
struct StressVariant {
  double scale = 1.0;
  double offset_extents = 0.0;
  double friction_static = 0.0;
  double friction_dynamic = 0.0;
};

// Scales 1e-6 to 1e6, offsets up to a million extents, and friction.
std::vector<StressVariant> standard_variants();
// Patches lie on a grid of their own, on which a body lies where it is made: without friction and with it.
std::vector<StressVariant> patch_variants();

struct StressPlan {
  MethodSettings method;
  std::uint64_t seed = 1;
  std::uint64_t steps = 100000;  // a body at least, shared by the variants; episodes are whole, and long walks come on top
  std::size_t compare_every = 64;
  double probe_share = 0.0;  // above 0: this probe for every body instead of its own, as a share of its longest side
  bool by_patches = false;   // the scene is felt by patches (patch_method.h); method proxy
  bool on_grid = false;      // the vertices are rounded to the grid of patches, and felt whole
  bool no_seal = false;      // mesh files are taken as they are, their cracks open
  unsigned threads = 1;
  std::vector<StressVariant> variants = standard_variants();
};

// What one body went through in one variant.
struct StressResult {
  std::string body;
  StressVariant variant;
  StressCount count;
};

// Runs every body in every variant; `progress` is called from one thread at a time, after each.
Result<std::vector<StressResult>> run_stress(const std::vector<StressBody>& bodies, const StressPlan& plan,
                                             const std::function<void(const StressResult&)>& progress);

// Only one episode of every body and variant.
Result<std::vector<StressResult>> run_episode(const std::vector<StressBody>& bodies, const StressPlan& plan, std::uint64_t episode);

// A table for people, a line a body, what its columns mean, and the findings, each with the command that shows it again.
std::string to_text(const std::vector<StressResult>& results, const StressPlan& plan);
std::string to_json(const std::vector<StressResult>& results, const StressPlan& plan);

// Sum over all results.
StressCount sum_of(const std::vector<StressResult>& results);

}  // namespace hapton
