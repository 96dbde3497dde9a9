#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "closed_loop/recommendation.h"
#include "closed_loop/turning_axis.h"
#include "core/base/rounded_down.h"
#include "tools/commands.h"
#include "tools/latency/latency_compare.h"
#include "tools/loop/loop_flags.h"
#include "tools/loop/measured_latency.h"

namespace hapton {
namespace {

struct RecommendOptions {
  LoopFlags loop;
  std::optional<double> rate_hz;
  std::optional<double> delay_ms;
  std::string report;
  bool json = false;
};

struct Advice {
  MeasuredLatency latency;
  const NamedLoop* loop = nullptr;
  Recommendation recommendation;
};

Result<MeasuredLatency> latency_of(const RecommendOptions& options) {
  MeasuredLatency latency{.rate_hz = 1000.0};
  if (!options.report.empty()) {
    const auto report = read_report_json(options.report);
    if (!report) return tl::unexpected(report.error());
    auto measured = read_measured_latency(*report);
    if (!measured) return fail("{}: {}", options.report, measured.error().what);
    latency = *measured;
  } else if (!options.delay_ms) {
    return fail("give --latency REPORT, which hapton latency run --out DIR writes, or --delay MS");
  }
  if (options.delay_ms) latency.delay_s = 1e-3 * *options.delay_ms;
  if (options.rate_hz) latency.rate_hz = *options.rate_hz;
  return latency;
}

// JSON has no infinity.
nlohmann::ordered_json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

// Recommends the stiffness for the device and hand that allow the least. Damping and rotational stiffness are each the least of all.
Result<void> run(const RecommendOptions& options) {
  const auto latency = latency_of(options);
  if (!latency) return tl::unexpected(latency.error());
  const auto loops = loops_of(options.loop);
  if (!loops) return tl::unexpected(loops.error());
  std::optional<Advice> strictest;
  double damping_ns_per_m = std::numeric_limits<double>::infinity();
  double viscosity_ns_per_m = damping_ns_per_m;
  double rotational_nm_per_rad = damping_ns_per_m;  // infinite: no device has motors that turn the stylus
  for (const NamedLoop& loop : *loops) {
    const Recommendation advice = recommend_stiffness(loop.device_model, loop.limits, loop.hand_model, latency->rate_hz, latency->delay_s);
    damping_ns_per_m = std::min(damping_ns_per_m, advice.damping_ns_per_m);
    viscosity_ns_per_m = std::min(viscosity_ns_per_m, advice.viscosity_ns_per_m);
    if (loop.limits.max_torque_nm > 0.0) {
      rotational_nm_per_rad = std::min(rotational_nm_per_rad, recommend_rotational_stiffness(loop.hand_model, loop.limits.max_torque_nm,
                                                                                             latency->rate_hz, latency->delay_s));
    }
    if (!strictest || advice.stiffness_n_per_m < strictest->recommendation.stiffness_n_per_m) strictest = Advice{*latency, &loop, advice};
  }
  const Recommendation& advice = strictest->recommendation;
  if (options.json) {
    const nlohmann::ordered_json json = {{"schema", "hapton.loop.recommend/1"},
                                         {"device", strictest->loop->device},
                                         {"hand", strictest->loop->hand},
                                         {"rate_hz", latency->rate_hz},
                                         {"delay_ms", 1e3 * latency->delay_s},
                                         {"recommended_stiffness_n_per_m", advice.stiffness_n_per_m},
                                         {"stable_stiffness_n_per_m", advice.stable_n_per_m},
                                         {"passive_stiffness_n_per_m", advice.passive_n_per_m},
                                         {"device_stiffness_n_per_m", advice.device_n_per_m},
                                         {"recommended_damping_ns_per_m", number_or_null(damping_ns_per_m)},
                                         {"recommended_viscosity_ns_per_m", number_or_null(viscosity_ns_per_m)},
                                         {"recommended_rotational_stiffness_nm_per_rad", number_or_null(rotational_nm_per_rad)},
                                         {"gain_margin", kGainMargin},
                                         {"limited_by", advice.is_limited_by_device ? "device" : "stability"}};
    fmt::print("{}\n", json.dump(2));
    return {};
  }
  fmt::print("{:.4g} N/m for {} at {:g} Hz and {:.4g} ms: {}\n", advice.stiffness_n_per_m,
             strictest->loop->is_own() ? "your own loop" : strictest->loop->device, latency->rate_hz, 1e3 * latency->delay_s,
             advice.is_limited_by_device
                 ? "the documented limit of the device"
                 : fmt::format("half of the stable limit{} ({:.4g} N/m)",
                               strictest->loop->is_own() ? "" : " with hand " + strictest->loop->hand, advice.stable_n_per_m));
  fmt::print(
      "Up to {:.4g} N/m no hand can draw energy from it. In a scene file: stiffness_n_per_m = {:.4g}. For any material: haptics_node "
      "--coupling {:.4g}\n",
      advice.passive_n_per_m, advice.stiffness_n_per_m, advice.stiffness_n_per_m);
  fmt::print("Damping: damping_ns_per_m of a material {:.3g} at most, viscosity_ns_per_m and viscous effects {:.3g}\n", damping_ns_per_m,
             viscosity_ns_per_m);
  if (std::isfinite(rotational_nm_per_rad))
    fmt::print("A rigid tool: haptics_node --rotational-stiffness {:.2g} at most (Nm/rad, about the grip)\n",
               rounded_down(rotational_nm_per_rad));
  return {};
}

}  // namespace

void add_loop_recommend_command(CommandLine loop, int& exit_code) {
  auto options = std::make_shared<RecommendOptions>();
  options->loop.hand = "light,stylus,arm,firm";
  const CommandLine command = loop.add_subcommand("recommend", "The stiffest safe material for a device, hands, rate and measured latency");
  add_loop_flags(command, options->loop, true);
  command.add_option("--latency", options->report, "report.json of hapton latency run, or its folder: rate, and delay at p99.9");
  command.add_option("--delay", options->delay_ms, "From the sample to its force on the motors, ms (in place of the report's)")
      .between(0.0, 10'000.0);
  command.add_option("--rate", options->rate_hz, "Servo rate, Hz (the report's, else 1000)").between(10.0, 1e6);
  command.add_flag("--json", options->json, "Print JSON");
  command.on_run([options, &exit_code] {
    const auto done = run(*options);
    if (!done) fmt::print(stderr, "hapton loop recommend: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
