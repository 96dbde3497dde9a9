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
  std::size_t steps = 4000;         // steps of each scenario but the peg
  std::size_t peg_steps = 100'000;  // steps of the scenario of a peg in a hole
  std::uint64_t seed = 1;
  TimingBudget budget{.repetitions = 3, .seconds = 20.0};
  bool with_large = true;  // true: also a tool of 50,000 triangles on a scene of 1,000,000
  // Other methods to measure besides ours: on each scenario, except the peg, whose scene has at most their most_triangles.
  std::vector<SixdofMethodKind> compared;
};

// Results of one method on one scenario. Errors are over all steps, angles over those with a force (torque) that is also expected.
struct SixdofRow {
  std::string name;
  std::string method;
  std::size_t contact_steps = 0;
  double force_error_percent = 0.0;   // RMS of the difference, as a share of the RMS of the expected force
  double force_angle_deg = 0.0;       // RMS of the angle between the force and the expected one
  double torque_error_percent = 0.0;  // the same for torque; if none is expected: a share of the expected force times the coupling's lever
  double torque_angle_deg = 0.0;      // RMS of that angle for torque; 0 if no step expects a torque
  bool has_errors = false;
  std::size_t penetrations = 0;  // steps in which a triangle of the tool intersects one of the scene (exact)
  double least_gap = 0.0;        // smallest gap of all steps, as a share of the contact offset; infinite: never below 2
  double widest_gap_um = 0.0;    // largest gap up to 1 mm in contact, in every 16th step and scenes of at most 200,000 triangles; 0: none
  std::size_t unconverged = 0;   // steps whose proxy did not converge
  int most_rounds = 0;           // most rounds of the proxy's iteration in one step
  double mean_rounds = 0.0;      // mean over the steps in contact
  int most_haptons = 0;          // most contacts of one step: local minima of the distance between tool and scene
  TimeSpread contact;            // times of SixdofMethod::step in the steps in contact
};

struct SixdofReport {
  RunConditions conditions;
  std::vector<SixdofRow> rows;
  std::vector<std::string> methods;  // ours and the compared ones: name and description
};

// Compares force and torque with analytic scenarios, checks gaps exactly, and measures run time on meshes of several sizes. Error: see
// ToolStep::make. RT: set-up only.
Result<SixdofReport> measure_sixdof(const SixdofSettings& settings, const Stopwatch& watch, const Progress& progress);

// Measures one method on one scenario, as measure_sixdof does.
Result<SixdofRow> measure_scenario(const SixdofScenario& scenario, const SixdofMethodKind& kind, const Stopwatch& watch,
                                   const TimingBudget& budget);

std::string to_csv(const SixdofReport& report);
std::string to_json(const SixdofReport& report);
std::string to_text(const SixdofReport& report);

}  // namespace hapton
