#include "bench/measure/run_conditions.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/measure/cpu_pin.h"

namespace hapton {
namespace {

// Share by which two calibrations of the time stamp counter may differ before the report warns. Calibrations of a good counter agree far
// better; a free choice.
constexpr double kTrustedDrift = 0.01;

}  // namespace

bool RunConditions::was_shared() const { return std::max(load_before, load_after) > static_cast<double>(machine.cpu_count); }

std::string RunConditions::to_text() const {
  std::string text =
      fmt::format("{}, {} CPUs, {}, {}, {}; seed {}; load {:.1f} before, {:.1f} after; clock {:.1f} ns, taken off, in steps of {:.2g} ns",
                  machine.cpu, machine.cpu_count, machine.kernel, machine.compiler, machine.build, seed, load_before, load_after,
                  clock_cost_ns, clock_resolution_ns);
  if (clock_drift > kTrustedDrift) {
    text += fmt::format("; the time stamp counter drifts by {:.1f} %: do not trust these times", 100.0 * clock_drift);
  }
  if (was_shared()) text += "; other programs were running: times are upper bounds, above all the maxima";
  if (!missing_peers.empty()) text += fmt::format("; not built: {}", fmt::join(missing_peers, ", "));
  return text;
}

RunConditions begin_conditions(const Stopwatch& watch, std::uint64_t seed) {
  RunConditions conditions;
  conditions.machine = read_machine_info();
  conditions.seed = seed;
  conditions.load_before = read_load_average();
  conditions.clock_cost_ns = watch.cost_ns();
  conditions.clock_resolution_ns = watch.resolution_ns();
  conditions.clock_drift = watch.drift();
  return conditions;
}

void end_conditions(RunConditions& conditions, std::uint64_t start_ticks, const Stopwatch& watch) {
  conditions.load_after = read_load_average();
  conditions.seconds = 1e-9 * watch.ns_between(start_ticks, Stopwatch::ticks());
}

nlohmann::ordered_json to_json(const RunConditions& conditions, const std::string& program) {
  const MachineInfo& machine = conditions.machine;
  return {{"schema", kBenchSchema},
          {"program", program},
          {"machine",
           {{"cpu", machine.cpu},
            {"cpu_count", machine.cpu_count},
            {"kernel", machine.kernel},
            {"compiler", machine.compiler},
            {"build", machine.build}}},
          {"seed", conditions.seed},
          {"load_before", conditions.load_before},
          {"load_after", conditions.load_after},
          {"machine_was_shared", conditions.was_shared()},
          {"clock_cost_ns", conditions.clock_cost_ns},
          {"clock_resolution_ns", conditions.clock_resolution_ns},
          {"clock_drift", conditions.clock_drift},
          {"seconds", conditions.seconds},
          {"not_built", conditions.missing_peers}};
}

}  // namespace hapton
