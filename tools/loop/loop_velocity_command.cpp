#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "closed_loop/velocity_estimator.h"
#include "tools/commands.h"
#include "tools/loop/loop_flags.h"

namespace hapton {
namespace {

constexpr double kMaxNoiseN = 0.1;  // of the damping force; assumed to be about what a finger begins to notice as a buzz

struct VelocityOptions {
  LoopFlags loop;
  double rate_hz = 1000.0;
  double damping_ns_per_m = 5.0;
  bool json = false;
};

void print_json(const VelocityOptions& options, const NamedLoop& loop, const std::vector<VelocityRow>& rows, const VelocityRow* chosen) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const VelocityRow& row : rows) {
    list.push_back({{"estimator", row.filter.name()},
                    {"noise_m_per_s", row.quality.noise_m_per_s},
                    {"lag_s", row.quality.lag_s},
                    {"noise_n", options.damping_ns_per_m * row.quality.noise_m_per_s}});
  }
  const nlohmann::ordered_json json = {
      {"schema", "hapton.loop.velocity/1"},
      {"device", loop.device},
      {"rate_hz", options.rate_hz},
      {"encoder_step_m", loop.device_model.encoder_step_m},
      {"damping_ns_per_m", options.damping_ns_per_m},
      {"most_noise_n", kMaxNoiseN},
      {"chosen", chosen != nullptr ? nlohmann::ordered_json(chosen->filter.name()) : nlohmann::ordered_json()},
      {"rows", list}};
  fmt::print("{}\n", json.dump(2));
}

void print_table(const VelocityOptions& options, const NamedLoop& loop, const std::vector<VelocityRow>& rows, const VelocityRow* chosen) {
  fmt::print("{}: encoder step {:.3g} mm, {:g} Hz\n", loop.device, 1e3 * loop.device_model.encoder_step_m, options.rate_hz);
  fmt::print("{:22} {:>12} {:>10} {:>22}\n", "estimator", "noise mm/s", "lag ms",
             fmt::format("noise N at {:g} Ns/m", options.damping_ns_per_m));
  for (const VelocityRow& row : rows) {
    fmt::print("{:22} {:>12.3g} {:>10.3g} {:>22.3g}\n", row.filter.name(), 1e3 * row.quality.noise_m_per_s, 1e3 * row.quality.lag_s,
               options.damping_ns_per_m * row.quality.noise_m_per_s);
  }
  fmt::print("noise: RMS error at the worst of six steady speeds from 1 to 300 mm/s; lag: at a steady 1 m/s^2\n");
  fmt::print("least lag with at most {:g} N of noise: {}\n", kMaxNoiseN,
             chosen != nullptr ? chosen->filter.name() : "none; lower the damping");
}

Result<void> run(const VelocityOptions& options) {
  const auto loops = loops_of(options.loop);
  if (!loops) return tl::unexpected(loops.error());
  const NamedLoop& loop = loops->front();
  const std::vector<VelocityRow> rows = compare_velocity(1.0 / options.rate_hz, loop.device_model.encoder_step_m);
  const VelocityRow* chosen = choose_velocity(rows, kMaxNoiseN / options.damping_ns_per_m);
  options.json ? print_json(options, loop, rows, chosen) : print_table(options, loop, rows, chosen);
  return {};
}

}  // namespace

void add_loop_velocity_command(CommandLine loop, int& exit_code) {
  auto options = std::make_shared<VelocityOptions>();
  const CommandLine command = loop.add_subcommand("velocity", "Velocity estimators compared: noise against lag");
  add_loop_flags(command, options->loop, false);
  command.add_option("--rate", options->rate_hz, "Servo rate, Hz").between(10.0, 1e5).shows_default();
  command.add_option("--damping", options->damping_ns_per_m, "Damping that uses the velocity, Ns/m")
      .positive("Ns/m")
      .between(0.0, 1e6)
      .shows_default();
  command.add_flag("--json", options->json, "Print JSON");
  command.on_run([options, &exit_code] {
    const auto done = run(*options);
    if (!done) fmt::print(stderr, "hapton loop velocity: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
