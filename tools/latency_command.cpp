#include "tools/latency_command.h"

#include <fmt/core.h>

#include <cstdio>
#include <memory>

#include "core/force/force_method.h"
#include "link/messages.h"
#include "runtime/realtime.h"
#include "tools/latency_run.h"

namespace hapton {
namespace {

int run(const LatencyRunOptions& options) {
  const auto told = run_latency(options);
  if (!told) {
    fmt::print(stderr, "hapton latency: {}\n", told.error().what);
    return 1;
  }
  fmt::print("{}", *told);
  return 0;
}

}  // namespace

void add_latency_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<LatencyRunOptions>();
  options->cpu = find_shared_cpu();
  CLI::App* command = app.add_subcommand("latency", "Measure the force round trip on this machine, beside a bare UDP echo");
  command->add_option("--seconds", options->seconds, "How long")->check(CLI::Range(0.5, 1e6))->capture_default_str();
  command->add_option("--rate", options->rate_hz, "Servo rate, Hz")
      ->check(CLI::Range(kMinServoRateHz, kMaxServoRateHz))
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder for report.json, latency.csv, latency.png and the nodes' logs")->capture_default_str();
  command->add_option("--scene", options->scene, "What is touched")->capture_default_str();
  command->add_option("--method", options->method, "Force method, one of: " + method_names() + " (default: the haptics node's)");
  command->add_option("--rt", options->realtime, "Real-time scheduling of the nodes: try, require or off")
      ->check(CLI::IsMember({"try", "require", "off"}))
      ->capture_default_str();
  command->add_option("--cpu", options->cpu, "Nodes and echo all stay on this CPU; -1: any; the last one by itself")
      ->check(CLI::Range(-1, 1023))
      ->capture_default_str();
  command->callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
