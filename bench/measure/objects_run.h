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

// One query or step over a scene of many objects, and the same over the touched object alone.
struct ObjectsRow {
  std::size_t objects = 0;
  std::size_t triangles = 0;  // of all objects
  std::string what;           // "contact step, point", "local set of 64" ...
  TimeSpread all, alone;      // least of the repetitions, a step
  double all_mean_ns = 0.0;   // without reading the clock in between; 0: not measured
  double alone_mean_ns = 0.0;
};

struct ObjectsReport {
  RunConditions conditions;
  std::vector<ObjectsRow> rows;
};

// Tori in a cubic lattice, with gaps wider than the device's motion. Only the middle one is touched, so the rows show the cost of the other
// objects. Error: see make_method. RT: set-up only.
Result<ObjectsReport> measure_objects(const ObjectsSettings& settings, const Stopwatch& watch, const Progress& progress);

std::string to_csv(const ObjectsReport& report);
std::string to_json(const ObjectsReport& report);
std::string to_text(const ObjectsReport& report);

}  // namespace hapton
