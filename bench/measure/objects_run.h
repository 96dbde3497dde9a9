#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure/method_run.h"
#include "bench/measure/pareto_run.h"
#include "bench/measure/run_conditions.h"

namespace hapton {

struct ObjectsSettings {
  std::vector<std::size_t> counts = {1, 10, 100, 1000};  // of objects, each scene with the same number of triangles in all
  std::size_t triangles = 1'000'000;                     // in all, about
  std::size_t steps = 8000;                              // of each trajectory
  std::uint64_t seed = 1;
  TimingBudget budget{.repetitions = 6, .seconds = 2.0};
};

// One query or step over a scene of many objects beside the same over the object that is touched alone.
struct ObjectsRow {
  std::size_t objects = 0;
  std::size_t triangles = 0;  // of all objects
  std::string what;           // "contact step, point", "local set of 64" ...
  TimeSpread all, alone;      // least of the repetitions, a step
  double all_mean_ns = 0.0;   // without a look at the clock in between; 0: not measured
  double alone_mean_ns = 0.0;
};

struct ObjectsReport {
  RunConditions conditions;
  std::vector<ObjectsRow> rows;
};

// Tori in a cubic lattice, the gaps wider than what the device moves in round the middle one, which alone is touched: what a step costs
// for the others being there. Error: as make_method. RT: set-up only.
Result<ObjectsReport> measure_objects(const ObjectsSettings& settings, const Stopwatch& watch, const Progress& progress);

std::string to_csv(const ObjectsReport& report);
std::string to_json(const ObjectsReport& report);
std::string to_text(const ObjectsReport& report);

}  // namespace hapton
