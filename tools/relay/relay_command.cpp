#include <fmt/core.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "link/random_id.h"
#include "link/relay_endpoint.h"
#include "link/udp_endpoint.h"
#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "runtime/stop_signal.h"
#include "tools/commands.h"
#include "tools/milliseconds.h"
#include "tools/relay/relay_report.h"
#include "tools/relay/relay_script.h"

namespace hapton {
namespace {

constexpr double kLongestDelayMs = 60'000.0;                              // a minute; a free choice
constexpr std::int64_t kCheckPeriodNs = 50 * kNanosecondsPerMillisecond;  // time between two checks whether to end; a free choice

struct RelayOptions {
  std::string listen = "127.0.0.1:0";
  std::string hub = "127.0.0.1";
  std::string direction = "both";
  std::string script;
  std::string json;
  std::optional<std::uint64_t> seed;
  double seconds = 0.0;
  LinkFaults faults;
  double delay_ms = 0.0;
  double jitter_ms = 0.0;
  double reorder_ms = 1e-6 * static_cast<double>(LinkFaults().reorder_by_ns);
};

FaultSchedule make_schedule(const RelayOptions& options) {
  LinkFaults faults = options.faults;
  faults.delay_ns = ms_to_ns(options.delay_ms);
  faults.jitter_ns = ms_to_ns(options.jitter_ms);
  faults.reorder_by_ns = ms_to_ns(options.reorder_ms);
  FaultPhase phase{.name = "flags", .to_hub = {}, .to_nodes = {}};
  if (options.direction != "to-nodes") phase.to_hub = faults;
  if (options.direction != "to-hub") phase.to_nodes = faults;
  return {.phases = {std::move(phase)}, .repeat = false};
}

Result<RelaySettings> make_settings(const RelayOptions& options) {
  const auto hub = parse_address(options.hub);
  if (!hub) return tl::unexpected(hub.error());
  RelaySettings settings{.listen = options.listen, .hub = *hub, .schedule = make_schedule(options), .seed = 1};
  std::optional<std::uint64_t> seed = options.seed;
  if (!options.script.empty()) {
    auto script = read_relay_script(options.script);
    if (!script) return tl::unexpected(script.error());
    settings.schedule = std::move(script->schedule);
    if (!seed) seed = script->seed;
  }
  // A random seed is short, so that a person can type it again.
  settings.seed = seed.value_or(make_random_id() % 1'000'000);
  return settings;
}

// Reports the beginning of each phase.
class PhaseReporter {
 public:
  explicit PhaseReporter(const FaultSchedule& schedule) : schedule_(schedule) {}
  void report_changes(const RelayEndpoint& relay) {
    if (relay.phase() == phase_shown_) return;
    phase_shown_ = relay.phase();
    if (schedule_.phases.size() == 1 && schedule_.phases[0].duration_ns == FaultPhase::kForever) return;
    fmt::print("phase {}\n", phase_shown_ < schedule_.phases.size() ? schedule_.phases[phase_shown_].name : "none: no faults");
    std::fflush(stdout);
  }

 private:
  const FaultSchedule& schedule_;
  std::size_t phase_shown_ = static_cast<std::size_t>(-1);
};

Result<void> relay(const RelayOptions& options) {
  const auto settings = make_settings(options);
  if (!settings) return tl::unexpected(settings.error());
  auto endpoint = RelayEndpoint::open(*settings);
  if (!endpoint) return tl::unexpected(endpoint.error());
  fmt::print("relay at {}, hub {}, seed {}\n", to_string(endpoint->local_address()), to_string(settings->hub), settings->seed);
  std::fflush(stdout);
  const StopSignal stop;
  const SteadyClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const auto passed_s = [&] { return 1e-9 * static_cast<double>(clock.now_ns() - start_ns); };
  PhaseReporter reporter(settings->schedule);
  while (!stop.stop_requested() && (options.seconds <= 0.0 || passed_s() < options.seconds)) {
    reporter.report_changes(*endpoint);
    endpoint->run_for_ns(kCheckPeriodNs);
  }
  fmt::print("{}", relay_text(*endpoint, settings->seed));
  if (options.json.empty()) return {};
  return write_file_atomically(options.json, relay_json(*endpoint, settings->seed, passed_s()));
}

int run(const RelayOptions& options) {
  const auto ended = relay(options);
  if (!ended) fmt::print(stderr, "hapton relay: {}\n", ended.error().what);
  return ended ? 0 : 1;
}

}  // namespace

void add_relay_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<RelayOptions>();
  const CommandLine command = app.add_subcommand("relay", "Simulate a bad network between the nodes and their hub");
  command.add_option("--listen", options->listen, "Address for the nodes to use as hub; port 0: any free one").shows_default();
  command.add_option("--hub", options->hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--seed", options->seed, "Seed; the same seed affects the same datagrams (default: the script's, else random)");
  command.add_option("--seconds", options->seconds, "End after this long, s; 0: when stopped (Ctrl-C)").between(0.0, 1e9).shows_default();
  command.add_option("--json", options->json, "Write the counters to this file at the end").file_to_write();
  const CommandOption script =
      command.add_option("--script", options->script, "TOML file of phases, each with faults and seconds; see docs/faults.md");

  LinkFaults& faults = options->faults;
  const CommandOption flags[] = {
      command.add_option("--direction", options->direction, "Direction of the faults below: both, to-hub or to-nodes")
          .one_of({"both", "to-hub", "to-nodes"})
          .shows_default(),
      command.add_option("--delay-ms", options->delay_ms, "Delay of every datagram").between(0.0, kLongestDelayMs),
      command.add_option("--jitter-ms", options->jitter_ms, "Random extra delay, up to this").between(0.0, kLongestDelayMs),
      command.add_option("--loss", faults.loss, "Share of datagrams lost, each independently").between(0.0, 1.0),
      command.add_option("--burst-share", faults.burst_share, "Share in a burst (Gilbert-Elliott)").between(0.0, 1.0),
      command.add_option("--burst-length", faults.burst_length, "Datagrams in a burst, on average").between(1.0, 1e6).shows_default(),
      command.add_option("--burst-loss", faults.burst_loss, "Share lost in a burst").between(0.0, 1.0).shows_default(),
      command.add_option("--reorder", faults.reorder, "Share held back, so that later ones overtake it").between(0.0, 1.0),
      command.add_option("--reorder-ms", options->reorder_ms, "How long these are held back").between(0.0, kLongestDelayMs).shows_default(),
      command.add_option("--duplicate", faults.duplicate, "Share sent twice").between(0.0, 1.0),
      command.add_option("--corrupt", faults.corrupt, "Share with one byte changed").between(0.0, 1.0),
      command.add_flag("--partition", faults.partition, "Drop every datagram"),
  };
  for (const CommandOption flag : flags) script.excludes(flag);
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
