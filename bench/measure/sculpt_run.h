#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure/pareto_run.h"
#include "bench/measure/run_conditions.h"
#include "bench/measure/step_times.h"
#include "core/base/result.h"

namespace hapton {

struct SculptRunSettings {
  std::vector<int> grids = {64, 128, 192};              // voxels along the longest side of the body
  std::vector<double> radii_voxels = {2.0, 5.0, 12.0};  // radii of the ball that carves
  std::vector<std::uint64_t> seeds = {1, 2};            // one motion for each seed
  std::size_t steps = 20'000;
  TimingBudget budget{.repetitions = 6, .seconds = 60.0};
};

// Results with one body, one ball and one motion: the hand moves at 0.2 m/s from one random point in and around the body to the next, and
// the button is down two thirds of the time. Each repetition begins with the uncarved body.
struct SculptRunRow {
  std::string shape;
  int grid = 0;
  double radius_voxels = 0.0;
  std::uint64_t seed = 0;
  std::size_t nodes = 0;     // nodes of the body's field
  std::size_t carves = 0;    // carves made in all steps
  double make_ms = 0.0;      // time to make the method with its field, once
  TimeSpread all = {};       // all steps, least times over the repetitions
  TimeSpread carving = {};   // the steps that made a carve
  TimeSpread touching = {};  // the steps in contact without a carve
  TimeSpread surface = {};   // carving and its changed surface blocks in three levels of detail, for each 33 ms that have a carve
  double whole_ms = 0.0;     // time for the surface of all blocks
  double undo_ms = 0.0;      // time to put the material of the last press back; a slow task does this, not a step
  std::size_t presses = 0;   // presses of the button that made a carve
};

struct SculptRunReport {
  RunConditions conditions;
  std::size_t steps = 0;
  std::vector<SculptRunRow> rows;

  // The goals: a step in 300 us, the surface 20 times a second.
  static constexpr double kMaxStepNs = 300e3;
  static constexpr double kMinSurfaceHz = 20.0;
  double worst_step_ns() const;
  double least_surface_hz() const;  // rate at which the slowest surface can be computed
};

// Times the steps of method proxy on bodies that are carved, and the surface that vision_node draws. Error: that of make_method, such as a
// grid that is too fine. RT: set-up only.
Result<SculptRunReport> measure_sculpting(const SculptRunSettings& settings, const Stopwatch& watch, const Progress& progress);

std::string to_csv(const SculptRunReport& report);
std::string to_json(const SculptRunReport& report);
std::string to_text(const SculptRunReport& report);

}  // namespace hapton
