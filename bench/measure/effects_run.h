#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/measure/effect_error.h"
#include "bench/measure/method_run.h"
#include "bench/measure/pareto_run.h"
#include "bench/measure/run_conditions.h"

namespace hapton {

struct EffectsSettings {
  std::size_t triangles = 20'000;
  std::size_t steps = 8000;
  std::uint64_t seed = 1;
  TimingBudget budget{.repetitions = 8, .seconds = 2.0};
};

// Cost of the step of method proxy with one effect, on the same slide as without effects, and the error of its force on a plane.
struct EffectsRow {
  std::string effect;
  TimeSpread contact;                     // least times of the steps in contact
  double mean_ns = 0.0;                   // mean over all steps, without reading the clock in between; includes the time of other programs
  double added_ns = 0.0;                  // what the effect adds to the median time of a contact step
  std::optional<EffectError> error = {};  // none: as for measure_effect_error
};

struct EffectsReport {
  RunConditions conditions;
  std::vector<EffectsRow> rows;  // the first row is for no effect
};

// Measures what each effect adds to a step and how far its force is from its formula. Error: see make_method. RT: set-up only.
Result<EffectsReport> measure_effects(const EffectsSettings& settings, const Stopwatch& watch, const Progress& progress);

std::string to_csv(const EffectsReport& report);
std::string to_json(const EffectsReport& report);
std::string to_text(const EffectsReport& report);

}  // namespace hapton
