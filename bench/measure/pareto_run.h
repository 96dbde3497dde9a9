#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/measure/method_run.h"
#include "bench/measure/query_run.h"
#include "bench/measure/run_conditions.h"

namespace hapton {

struct ParetoSettings {
  std::size_t steps = 12000;          // steps of the slide
  std::size_t compared_steps = 1800;  // steps compared with the reference: the first of each piece between two resets
  std::uint64_t seed = 1;
  TimingBudget budget{.repetitions = 5, .seconds = 1.0};  // time for one row
};

// Results of one method along one slide over one mesh.
struct MethodRow {
  std::string mesh;
  std::size_t triangles = 0;
  std::string family;  // "proxy point", "proxy sphere", "sweep", "smooth", "smooth layer", "reference": each has its own mark in the plot
  MethodSettings settings;
  std::string structure;  // "adjacency + wide", "grid 32", "fdh 14, set 64"
  std::size_t steps = 0;
  MethodTiming timing;  // felt and contact_ns are empty
  ForceError error;
};

// Results of one structure with the queries of that slide.
struct QueryRow {
  std::string mesh;
  std::size_t triangles = 0;
  QueryStructureKind kind;  // its member make is empty
  StructureTiming timing;
};

struct ParetoReport {
  RunConditions conditions;
  std::vector<MethodRow> methods;
  std::vector<QueryRow> queries;
};

using Progress = std::function<void(const std::string&)>;

// Measures every method and the given structures over one mesh (usually 100 mm long) and adds them to the report. Error: a trajectory or a
// method that cannot be made. RT: set-up only.
Result<void> measure_pareto(const ParetoSettings& settings, const Stopwatch& watch, const std::string& name,
                            const std::shared_ptr<const TriangleMesh>& mesh, const std::vector<QueryStructureKind>& structures,
                            const Progress& progress, ParetoReport& report);

// One line for each row: methods first, then queries; columns that do not apply are empty.
std::string to_csv(const ParetoReport& report);
std::string to_json(const ParetoReport& report);
// For people: methods and queries of one mesh, or of all when the name is empty.
std::string to_text(const ParetoReport& report, const std::string& mesh);

// A mark without any error is drawn at this value, because the axis is logarithmic.
constexpr double kMinShownError = 1e-12;

// A mark in the plot: p99 of the times of contact steps against the RMS force error. The front is found among such marks.
struct ParetoMark {
  std::string mesh, family;
  std::string label;     // sweep: cells along an axis; smooth: triangles in the set, or "d6": directions of its hulls
  bool is_point = true;  // false: a sphere touches another surface, so it is drawn but does not compete for the front
  double time_us = 0.0;
  double error = 0.0;  // as a share; not below kMinShownError
};
std::vector<ParetoMark> pareto_marks(const ParetoReport& report);

}  // namespace hapton
