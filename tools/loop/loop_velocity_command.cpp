#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "loop/press.h"
#include "loop/velocity_estimator.h"
#include "tools/commands.h"
#include "tools/loop/loop_flags.h"
#include "tools/milliseconds.h"

namespace hapton {
namespace {

struct VelocityOptions {
  LoopFlags loop;
  double rate_hz = 1000.0;
  double delay_ms = 0.0;
  double stiffness_n_per_m = 300.0;
  bool json = false;
};

struct VelocityRow {
  VelocityFilter filter;
  VelocityQuality quality;
  double rest_damping_ns_per_m = 0.0;
};

VelocityRow measure(const VelocityOptions& options, const NamedLoop& loop, const VelocityFilter& filter) {
  constexpr double kMostDamping = 1000.0;
  PressCase press{.device = loop.device_model, .hand = loop.hand_model, .period_ns = ms_to_ns(1e3 / options.rate_hz), .velocity = filter};
  press.there.delay_ns = ms_to_ns(0.5 * options.delay_ms);
  press.back.delay_ns = ms_to_ns(options.delay_ms) - press.there.delay_ns;
  return {filter, measure_velocity(filter, 1.0 / options.rate_hz, loop.device_model.encoder_step_m),
          find_rest_damping(press, options.stiffness_n_per_m, kMostDamping)};
}

void print_json(const VelocityOptions& options, const NamedLoop& loop, const std::vector<VelocityRow>& rows) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const VelocityRow& row : rows) {
    list.push_back({{"estimator", row.filter.name()},
                    {"noise_m_per_s", row.quality.noise_m_per_s},
                    {"lag_s", row.quality.lag_s},
                    {"rest_damping_ns_per_m", row.rest_damping_ns_per_m}});
  }
  const nlohmann::ordered_json json = {{"schema", "hapton.loop.velocity/1"},
                                       {"device", loop.device},
                                       {"hand", loop.hand},
                                       {"rate_hz", options.rate_hz},
                                       {"delay_ms", options.delay_ms},
                                       {"encoder_step_m", loop.device_model.encoder_step_m},
                                       {"stiffness_n_per_m", options.stiffness_n_per_m},
                                       {"rows", list}};
  fmt::print("{}\n", json.dump(2));
}

void print_table(const VelocityOptions& options, const NamedLoop& loop, const std::vector<VelocityRow>& rows) {
  fmt::print("{} in hand {}, encoder step {:.3g} mm, {:g} Hz, {:g} ms\n", loop.device, loop.hand, 1e3 * loop.device_model.encoder_step_m,
             options.rate_hz, options.delay_ms);
  fmt::print("{:22} {:>12} {:>10} {:>20}\n", "estimator", "noise mm/s", "lag ms", "most damping Ns/m");
  for (const VelocityRow& row : rows) {
    fmt::print("{:22} {:>12.3g} {:>10.3g} {:>20.3g}\n", row.filter.name(), 1e3 * row.quality.noise_m_per_s, 1e3 * row.quality.lag_s,
               row.rest_damping_ns_per_m);
  }
  fmt::print(
      "noise: RMS error at the worst of six steady speeds from 1 to 300 mm/s; lag: at 1 m/s^2; most damping: of a wall of {:g} N/m on "
      "which a "
      "press comes to rest\n",
      options.stiffness_n_per_m);
}

Result<void> run(const VelocityOptions& options) {
  const auto loops = loops_of(options.loop);
  if (!loops) return tl::unexpected(loops.error());
  const NamedLoop& loop = loops->front();
  std::vector<VelocityRow> rows;
  for (const VelocityFilter& filter : velocity_filters()) rows.push_back(measure(options, loop, filter));
  options.json ? print_json(options, loop, rows) : print_table(options, loop, rows);
  return {};
}

}  // namespace

void add_loop_velocity_command(CommandLine loop, int& exit_code) {
  auto options = std::make_shared<VelocityOptions>();
  const CommandLine command =
      loop.add_subcommand("velocity", "Velocity estimators: noise against lag, and the damping a wall holds with each");
  add_loop_flags(command, options->loop, false);
  command.add_option("--rate", options->rate_hz, "Servo rate, Hz").between(10.0, 1e5).shows_default();
  command.add_option("--delay", options->delay_ms, "From the sample to its force on the motors, ms").between(0.0, 1000.0).shows_default();
  command.add_option("--stiffness", options->stiffness_n_per_m, "Of the wall, N/m").positive("N/m").shows_default();
  command.add_flag("--json", options->json, "Print JSON");
  command.on_run([options, &exit_code] {
    const auto done = run(*options);
    if (!done) fmt::print(stderr, "hapton loop velocity: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
