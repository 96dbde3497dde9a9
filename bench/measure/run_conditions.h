#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/measure/stopwatch.h"
#include "runtime/report.h"

namespace hapton {

constexpr const char* kBenchSchema = "hapton.bench/3";  // rises when a field of a report changes its name or meaning

// Conditions of a benchmark run.
struct RunConditions {
  MachineInfo machine;
  std::uint64_t seed = 1;
  double load_before = 0.0;  // load average of the last minute
  double load_after = 0.0;
  double clock_cost_ns = 0.0;  // this and the next two: from Stopwatch
  double clock_resolution_ns = 0.0;
  double clock_drift = 0.0;
  double seconds = 0.0;  // duration of the run
  std::vector<std::string> missing_peers;

  // True if other programs probably ran: the load, this program included, was above the number of CPUs.
  bool was_shared() const;
  // One line for people.
  std::string to_text() const;
};

// begin_conditions fills in the machine, the stopwatch and the load before; end_conditions the load after and the time since start_ticks.
RunConditions begin_conditions(const Stopwatch& watch, std::uint64_t seed);
void end_conditions(RunConditions& conditions, std::uint64_t start_ticks, const Stopwatch& watch);

// The beginning of every bench report: "schema", "program" and the conditions.
nlohmann::ordered_json to_json(const RunConditions& conditions, const std::string& program);

}  // namespace hapton
