#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure/method_run.h"
#include "bench/measure/pareto_run.h"
#include "bench/measure/run_conditions.h"

namespace hapton {

struct ObjectsSettings {
  std::vector<std::size_t> counts = {1, 10, 100, 1000};  // numbers of objects; all scenes have about the same number of triangles
  std::size_t triangles = 1'000'000;                     // triangles of all objects of a scene together, about
  std::size_t steps = 8000;                              // steps of each trajectory
  std::uint64_t seed = 1;
  TimingBudget budget{.repetitions = 6, .seconds = 2.0};
};

// Times of one query or step over a scene of many objects, and of the same over the touched object alone.
struct ObjectsRow {
  std::size_t objects = 0;
  std::size_t triangles = 0;  // of all objects
  std::string what;           // "contact step, point", "local set of 64" ...
  TimeSpread all, alone;      // spreads of the least times of a step over the repetitions
  double all_mean_ns = 0.0;   // mean step without reading the clock in between; 0: not measured
  double alone_mean_ns = 0.0;
};

struct ObjectsReport {
  RunConditions conditions;
  std::vector<ObjectsRow> rows;
};

// Tori in a cubic lattice, with gaps wider than the device's motion. Only the middle one is touched, so the rows show the cost of the other
// objects. Error: a count with which an object has fewer than 18 triangles; see make_method. RT: set-up only.
Result<ObjectsReport> measure_objects(const ObjectsSettings& settings, const Stopwatch& watch, const Progress& progress);

std::string to_csv(const ObjectsReport& report);
std::string to_json(const ObjectsReport& report);
std::string to_text(const ObjectsReport& report);

}  // namespace hapton
