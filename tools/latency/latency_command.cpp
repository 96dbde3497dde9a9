#include <fmt/ranges.h>

#include <array>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>

#include "core/force/force_method.h"
#include "link/link_key.h"
#include "link/messages.h"
#include "runtime/atomic_file.h"
#include "runtime/stop_signal.h"
#include "tools/commands.h"
#include "tools/latency/latency_compare.h"
#include "tools/latency/latency_run.h"
#include "tools/temporary_folder.h"

namespace hapton {
namespace {

// What the exit code tells: whether the run held its servo rate (by_verdict), or only whether it gave a result (by_measurement).
enum class Exit { by_verdict, by_measurement };

int run(const LatencyRunOptions& options, Exit exit) {
  const auto ran = run_latency(options);
  if (!ran) {
    fmt::print(stderr, "hapton latency: {}\n", ran.error().what);
    return 1;
  }
  fmt::print("{}", ran->text);
  return exit == Exit::by_measurement || ran->holds ? 0 : 1;
}

// Prints the choice, then a line for each node, which a script reads: the flags that pin it to the CPU where short runs were fastest.
int print_cpus(LatencyRunOptions options) {
  const StopSignal interrupts;
  const auto folder = TemporaryFolder::make();
  if (!folder) {
    fmt::print(stderr, "hapton latency cpus: {}\n", folder.error().what);
    return 1;
  }
  options.out = folder->path();
  const auto chosen = choose_cpus(options);
  if (!chosen || interrupts.stop_requested()) {
    fmt::print(stderr, "hapton latency cpus: {}\n", chosen ? "interrupted" : chosen.error().what);
    return 1;
  }
  fmt::print("{}\n", chosen->text.empty() ? "nothing was measured: there is one CPU, or --rt is off" : chosen->text);
  fmt::print("io_node {}\nhaptics_node {}\n", fmt::join(io_flags(chosen->cpus), " "), fmt::join(haptics_flags(chosen->cpus), " "));
  return 0;
}

struct CompareOptions {
  std::string a;
  std::string b;
  std::string json;
};

Result<void> compare(const CompareOptions& options) {
  const auto a = read_report_json(options.a);
  if (!a) return tl::unexpected(a.error());
  const auto b = read_report_json(options.b);
  if (!b) return tl::unexpected(b.error());
  fmt::print("A {}\nB {}\n{}", options.a, options.b, compare_text(*a, *b));
  if (options.json.empty()) return {};
  return write_file_atomically(options.json,
                               compare_json(*a, *b).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

int run_compare(const CompareOptions& options) {
  const auto compared = compare(options);
  if (!compared) fmt::print(stderr, "hapton latency compare: {}\n", compared.error().what);
  return compared ? 0 : 1;
}

std::array<CommandOption, 4> add_node_options(CommandLine command, LatencyRunOptions& options) {
  return {command.add_option("--rate", options.rate_hz, "Servo rate, Hz").between(kMinServoRateHz, kMaxServoRateHz).shows_default(),
          command.add_option("--scene", options.scene, "Scene to touch").shows_default(),
          command.add_option("--method", options.method, "Force method, one of: " + method_names() + " (default: the haptics node's)")
              .one_of_names(method_names()),
          command.add_option("--rt", options.realtime, "Real-time scheduling of the nodes: try, require or off")
              .one_of({"try", "require", "off"})
              .shows_default()};
}

void add_run_options(CommandLine command, LatencyRunOptions& options) {
  command.add_option("--seconds", options.seconds, "Duration, s").between(0.5, 1e6).shows_default();
  command.add_option("--out", options.out, "Folder for report.json, latency.csv, latency.png, latency.txt and the nodes' logs")
      .folder_to_write()
      .shows_default();
  const CommandOption hosts =
      command.add_option("--hosts", options.hosts, "Measure the system whose hub runs at HOST[:PORT], instead of starting one here");
  command.add_option("--key", options.key_file, kKeyHelp).needs(hosts);
  for (const CommandOption option : add_node_options(command, options)) hosts.excludes(option);
  const CommandOption of_our_own[] = {
      command.add_option("--size", options.echo_bytes, "Bytes of the bare echo's datagrams; 0: those of a device sample")
          .between(std::size_t{0}, kMaxDatagramBytes)
          .shows_default(),
      command.add_flag("--vision", options.vision, "Include a vision node: device to frame, motion to photon"),
      command
          .add_option("--cpu", options.cpu,
                      "Pin io_node and echo to this CPU; -1: any; by default measured: the nodes share the last CPU, or have one each")
          .between(-1, 1023),
      command.add_option("--haptics-cpu", options.haptics_cpu, "Pin haptics_node to this CPU; -1: any; default: as --cpu, or measured")
          .between(-1, 1023)};
  for (const CommandOption option : of_our_own) hosts.excludes(option);
}

}  // namespace

void add_latency_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<LatencyRunOptions>();
  const CommandLine command = app.add_subcommand("latency", "Measure the force round trip beside a bare UDP echo; compare runs");
  command.require_subcommands(0, 1);
  add_run_options(command, *options);
  const CommandLine run_command = command.add_subcommand("run", "As `hapton latency`; exit code 0: the rate was held");
  add_run_options(run_command, *options);
  run_command.on_run([options, &exit_code] { exit_code = run(*options, Exit::by_verdict); });

  auto cpus_options = std::make_shared<LatencyRunOptions>();
  const CommandLine cpus_command =
      command.add_subcommand("cpus", "The CPUs on which io_node and haptics_node reply fastest here, as flags for both; 3 s");
  add_node_options(cpus_command, *cpus_options);
  cpus_command.on_run([cpus_options, &exit_code] { exit_code = print_cpus(*cpus_options); });

  auto compare_options = std::make_shared<CompareOptions>();
  const CommandLine compare_command = command.add_subcommand("compare", "Two runs side by side, with their ratios");
  compare_command.add_option("A", compare_options->a, "Folder of a run, or its report.json").required();
  compare_command.add_option("B", compare_options->b, "Folder or report.json of another run").required();
  compare_command.add_option("--json", compare_options->json, "Write the comparison to this file too").file_to_write();
  compare_command.on_run([compare_options, &exit_code] { exit_code = run_compare(*compare_options); });

  command.on_run([command, options, &exit_code] {
    if (!command.has_subcommand()) exit_code = run(*options, Exit::by_measurement);
  });
}

}  // namespace hapton
