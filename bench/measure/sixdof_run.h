#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure/pareto_run.h"
#include "bench/measure/run_conditions.h"
#include "bench/measure/sixdof_method.h"
#include "bench/measure/step_times.h"

namespace hapton {

struct SixdofSettings {
  std::size_t steps = 4000;         // of each scenario
  std::size_t peg_steps = 100'000;  // of the peg
  std::uint64_t seed = 1;
  TimingBudget budget{.repetitions = 3, .seconds = 20.0};
  bool with_large = true;  // 50 k triangles over 1 M
  // Besides ours; each on all scenarios but the peg, where its most_triangles allow.
  std::vector<SixdofMethodKind> compared;
};

// One scenario by one method. Errors are over the steps in which a force or torque of the given kind is expected.
struct SixdofRow {
  std::string name;
  std::string method;
  std::size_t contact_steps = 0;
  double force_error_percent = 0.0;   // RMS of the difference over the RMS of the expected
  double force_angle_deg = 0.0;       // RMS
  double torque_error_percent = 0.0;  // the same; of the force times the tool's mean lever where no torque is expected
  double torque_angle_deg = 0.0;      // 0 where no torque is expected
  bool has_errors = false;
  std::size_t penetrations = 0;  // steps in which a triangle of the tool intersects one of the scene (exact)
  double least_gap = 0.0;        // over all steps, as a share of the contact offset
  double widest_gap_um = 0.0;  // what contact keeps apart: the largest gap over the steps in contact that are measured; 0: none below 1 mm
  std::size_t unconverged = 0;
  int most_rounds = 0;
  double mean_rounds = 0.0;  // of the steps in contact
  int most_haptons = 0;
  TimeSpread contact;  // of the pose step
};

struct SixdofReport {
  RunConditions conditions;
  std::vector<SixdofRow> rows;
  std::vector<std::string> methods;  // those compared with: name and what they are
};

// Force and torque against the analytic scenarios, gaps by exact tests, and run time over sizes. Error: see ToolStep::make. RT: set-up
// only.
Result<SixdofReport> measure_sixdof(const SixdofSettings& settings, const Stopwatch& watch, const Progress& progress);

// The same for one scenario and method.
Result<SixdofRow> measure_scenario(const SixdofScenario& scenario, const SixdofMethodKind& kind, const Stopwatch& watch,
                                   const TimingBudget& budget);

std::string to_csv(const SixdofReport& report);
std::string to_json(const SixdofReport& report);
std::string to_text(const SixdofReport& report);

}  // namespace hapton
