#include "tools/latency/latency_run.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "runtime/atomic_file.h"
#include "runtime/bare_timer.h"
#include "runtime/hop_table.h"
#include "runtime/stop_signal.h"
#include "scene/find_scene.h"
#include "tools/child_process.h"
#include "tools/json_number.h"
#include "tools/latency/latency_compare.h"
#include "tools/latency/latency_csv.h"
#include "tools/latency/latency_plot.h"
#include "tools/latency/latency_verdict.h"
#include "tools/latency/latency_window.h"
#include "tools/latency/node_cpus.h"
#include "tools/latency/report_types.h"
#include "tools/live/hub_report.h"
#include "tools/local_node.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kGraceSeconds = 15.0;        // extra time for the hub to write its report
constexpr double kLongestTimerSeconds = 5.0;  // of each run of the bare timer, before and after the nodes; a free choice
constexpr double kTrialSeconds = 0.75;        // of a short run on each choice of CPUs; a free choice
constexpr double kIdleSeconds = 0.1;          // until an interrupt is noticed; a free choice
constexpr double kMaxSilenceSeconds = 2.0;    // a hub that is silent for longer is gone, not only slow; a free choice

Result<void> measure_here(const LatencyRunOptions& options, const NodeCpus& cpus) {
  const auto echo_address = find_free_address();
  const auto hub_address = find_free_address();
  if (!echo_address || !hub_address) {
    return tl::unexpected(echo_address ? hub_address.error() : echo_address.error());
  }
  const std::filesystem::path program_folder = find_own_folder();
  const std::string cpu = fmt::format("{}", cpus.io);
  // The echo is scheduled like the nodes: otherwise the ratio of round trip to echo would measure the scheduler.
  auto echo = LocalNode::start(options.out, "echo", program_folder / "hapton",
                               {"echo", "--bind", *echo_address, "--rt", options.realtime, "--cpu", cpu});
  if (!echo) {
    return tl::unexpected(echo.error());
  }
  std::vector<std::string> arguments = {"--hub", *hub_address, "--scene", options.scene.string(), "--rt", options.realtime};
  std::ranges::copy(haptics_flags(cpus), std::back_inserter(arguments));
  if (!options.method.empty()) {
    arguments.insert(arguments.end(), {"--method", options.method});
  }
  auto haptics = LocalNode::start(options.out, "haptics_node", program_folder / "haptics_node", std::move(arguments));
  if (!haptics) {
    return tl::unexpected(haptics.error());
  }
  LocalVision vision;
  if (options.vision) {
    if (const auto started = vision.start(options.out, {"--hub", *hub_address, "--scene", options.scene.string()}); !started) {
      return started;
    }
  }
  for (const auto& ready : {echo->wait_for("echo at"), haptics->wait_for("ready")}) {
    if (!ready) {
      return ready;
    }
  }
  std::vector<std::string> io_arguments = {"--bind",       *hub_address,
                                           "--echo-probe", *echo_address,
                                           "--echo-size",  fmt::format("{}", options.echo_bytes),
                                           "--rate",       fmt::format("{}", options.rate_hz),
                                           "--seconds",    fmt::format("{}", options.seconds),
                                           "--out",        options.out.string(),
                                           "--rt",         options.realtime};
  std::ranges::copy(io_flags(cpus), std::back_inserter(io_arguments));
  auto io = LocalNode::start(options.out, "io_node", program_folder / "io_node", std::move(io_arguments));
  if (!io) {
    return tl::unexpected(io.error());
  }
  for (const auto& ended : {io->wait_for_end(options.seconds + kGraceSeconds), haptics->stop(), echo->stop(), vision.stop()}) {
    if (!ended) {
      return ended;
    }
  }
  return {};
}

Result<TrialRun> try_cpus(const LatencyRunOptions& options, const NodeCpus& cpus) {
  LatencyRunOptions trial = options;
  trial.out = options.out / "trial";
  trial.seconds = kTrialSeconds;
  trial.vision = false;
  std::error_code error;
  std::filesystem::create_directories(trial.out, error);
  if (error) return fail("{}: cannot be made: {}", trial.out.string(), error.message());
  if (const auto measured = measure_here(trial, cpus); !measured) return tl::unexpected(measured.error());
  const auto report = read_report_json(trial.out);
  if (!report) return tl::unexpected(report.error());
  std::filesystem::remove_all(trial.out, error);
  if (json_number_of(*report, "counters", "forces") <= 0.0) return TrialRun{};
  const Json hop = report->value("hops", Json::object()).value("round_trip", Json::object());
  return TrialRun{hop.value("p50_us", TrialRun().p50_us), hop.value("p99_us", TrialRun().p99_us),
                  hop.value("max_us", TrialRun().longest_us)};
}

// Runs the bare timer for a quarter of the run's duration (at most kLongestTimerSeconds), on this CPU, with the priority of the nodes.
Result<BareTimer> measure_timer(const LatencyRunOptions& options, int cpu) {
  const auto mode = parse_realtime_mode(options.realtime);
  if (!mode) {
    return tl::unexpected(mode.error());
  }
  const bool is_ordinary = *mode == RealtimeMode::off;
  return measure_bare_timer({.mode = *mode, .priority = is_ordinary ? 0 : 80, .cpu = is_ordinary ? -1 : cpu, .lock_memory = false},
                            options.rate_hz, std::min(0.25 * options.seconds, kLongestTimerSeconds));
}

// Measures the nodes, and before and after them the bare timer on the same CPU: at the same time it would disturb them.
Result<BareTimer> measure_between_timers(const LatencyRunOptions& options, const NodeCpus& cpus) {
  auto timer = measure_timer(options, cpus.io);
  if (!timer) {
    return timer;
  }
  if (const auto measured = measure_here(options, cpus); !measured) {
    return tl::unexpected(measured.error());
  }
  const auto after = measure_timer(options, cpus.io);
  if (!after) {
    return after;
  }
  timer->merge(*after);
  return timer;
}

// Waits until the time is over or a stop is requested. Error: the hub is gone.
Result<void> wait_with_hub(HubReader& reader, const LatencyRunOptions& options, const StopSignal& interrupts) {
  double silent_s = 0.0;
  for (double remaining_s = options.seconds; remaining_s > 0.0 && !interrupts.stop_requested(); remaining_s -= kIdleSeconds) {
    silent_s = reader.idle(std::min(remaining_s, kIdleSeconds)) ? 0.0 : silent_s + kIdleSeconds;
    if (silent_s > kMaxSilenceSeconds) {
      return fail("the hub at {} does not reply any more; see its terminal", options.hosts);
    }
  }
  return {};
}

Result<void> measure_hub(const LatencyRunOptions& options, const StopSignal& interrupts) {
  const auto reader = HubReader::open(options.hosts, options.key_file);
  if (!reader) {
    return tl::unexpected(reader.error());
  }
  const auto before = (*reader)->read();
  if (!before) {
    return tl::unexpected(before.error());
  }
  if (const auto waited = wait_with_hub(**reader, options, interrupts); !waited) {
    return waited;
  }
  const auto now = (*reader)->read();
  if (!now) {
    return tl::unexpected(now.error());
  }
  const auto json_before = Json::parse(before->json, nullptr, false);
  const auto json_now = Json::parse(now->json, nullptr, false);
  if (!has_report_types(json_before) || !has_report_types(json_now)) {
    return fail("the hub at {} gives a report that cannot be read; it is another version of Hapton", options.hosts);
  }
  if (json_number_of(json_now, "seconds") < json_number_of(json_before, "seconds")) {
    return fail("the hub at {} was started again meanwhile; measure again", options.hosts);
  }
  const auto hops_now = parse_latency_csv(now->csv, "the hub's latency.csv");
  if (!hops_now) {
    return tl::unexpected(hops_now.error());
  }
  const auto hops = subtract_hops(*hops_now, parse_latency_csv(before->csv, "the hub's latency.csv").value_or(std::vector<HopCounts>()));
  if (const auto written = write_file_atomically(options.out / "latency.csv", to_csv(hops)); !written) {
    return written;
  }
  return write_file_atomically(options.out / "report.json",
                               make_window_report(json_before, json_now, hops).dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::string hops_text(const Json& hops) {
  std::vector<HopRow> rows;
  for (const auto& [name, hop] : hops.items()) {
    rows.push_back({.name = name,
                    .n = hop.value("n", std::uint64_t{0}),
                    .p50_us = hop.value("p50_us", 0.0),
                    .p90_us = hop.value("p90_us", 0.0),
                    .p99_us = hop.value("p99_us", 0.0),
                    .p99_9_us = hop.value("p99_9_us", 0.0),
                    .max_us = hop.value("max_us", 0.0)});
  }
  return make_hop_table(rows);
}

std::string counts_text(const Json& report) {
  const auto count = [&](const char* name) { return json_number_of(report, "counters", name); };
  const double seconds = std::max(1e-9, report.value("seconds", 0.0));
  std::string text = fmt::format(
      "{:.0f} samples, {:.0f} forces, {:.0f} in contact; {:.0f} late, {:.0f} lost, {:.0f} superseded, {:.0f} reordered, {:.0f} cycles "
      "missed\n",
      count("samples"), count("forces"), count("contact_samples"), count("late"), count("lost"), count("superseded"), count("reordered"),
      count("missed_cycles"));
  text +=
      fmt::format("on the wire: {:.0f} datagrams/s out ({:.1f} kB/s), {:.0f} in ({:.1f} kB/s)\n", count("datagrams_sent") / seconds,
                  1e-3 * count("bytes_sent") / seconds, count("datagrams_received") / seconds, 1e-3 * count("bytes_received") / seconds);
  return text +
         fmt::format("haptics' clock ahead of the hub's: {}\n", report.value("notes", Json::object()).value("haptics_clock_offset", "?"));
}

Json to_json(const BareTimer& timer) {
  const auto late_us = [&](double share) { return 1e-3 * timer.lateness.quantile_ns(share); };
  return {{"rate_hz", timer.rate_hz},        {"ticks", timer.ticks},
          {"missed", timer.missed},          {"missed_share", timer.missed_share()},
          {"late_p50_us", late_us(0.5)},     {"late_p99_us", late_us(0.99)},
          {"late_p99_9_us", late_us(0.999)}, {"late_max_us", 1e-3 * static_cast<double>(timer.lateness.max_ns())}};
}

std::string timer_text(const Json& report, const BareTimer& timer) {
  const double missed = json_number_of(report, "counters", "missed_cycles");
  const double cycles = std::max(1.0, json_number_of(report, "counters", "samples") + missed);
  const auto late_us = [&](double share) { return 1e-3 * timer.lateness.quantile_ns(share); };
  return fmt::format(
      "ticks missed: servo {:.3f} %, bare timer of the same CPU, before and after, {:.3f} % (late by p50 {:.1f}, p99 {:.1f}, p99.9 {:.1f} "
      "us)\n",
      100.0 * missed / cycles, 100.0 * timer.missed_share(), late_us(0.5), late_us(0.99), late_us(0.999));
}

// Adds the verdict, and the bare timer if one was measured, to the report's file. Returns the text of the whole result.
Result<LatencyRun> make_report(const std::filesystem::path& file, const BareTimer* timer) {
  const bool wants_echo = timer != nullptr;
  auto json = Json::parse(read_text(file), nullptr, false);
  if (!has_report_types(json) || !json.contains("hops")) {
    return fail("{}: is not a latency report", file.string());
  }
  const auto verdict = evaluate_latency(json);
  if (!verdict) {
    return fail("{}: {}", file.string(), verdict.error().what);
  }
  const auto ratios = json.value("ratios", Json::object());
  const bool has_echo = ratios.contains("round_trip_over_echo_p50");
  if (wants_echo && !has_echo) {
    return fail("{}: no echo was measured; see the logs beside it", file.string());
  }
  json["verdict"] = to_json(*verdict);
  if (timer != nullptr) {
    json["bare_timer"] = to_json(*timer);
  }
  if (const auto written = write_file_atomically(file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"); !written) {
    return tl::unexpected(written.error());
  }
  LatencyRun run{hops_text(json["hops"]) + counts_text(json), verdict->holds};
  run.text += has_echo ? fmt::format("force round trip over bare echo of the same run: p50 {:.2f} x, p99 {:.2f} x\n",
                                     json_number_of(json, "ratios", "round_trip_over_echo_p50"),
                                     json_number_of(json, "ratios", "round_trip_over_echo_p99"))
                       : "no bare echo: the hub was started without --echo-probe\n";
  run.text += timer != nullptr ? timer_text(json, *timer) : "";
  run.text += to_text(*verdict);
  return run;
}

}  // namespace

Result<CpuChoice> choose_cpus(const LatencyRunOptions& options) {
  const auto is_given = [](int cpu) { return cpu != LatencyRunOptions::kChosenByRuns; };
  if (is_given(options.cpu) || is_given(options.haptics_cpu)) {
    const int io = is_given(options.cpu) ? options.cpu : options.haptics_cpu;
    return CpuChoice{{io, is_given(options.haptics_cpu) ? options.haptics_cpu : io}, {}};
  }
  const NodeCpus two_cpus = find_two_cpus();
  if (two_cpus.io < 0 || options.realtime == "off") return CpuChoice{find_one_cpu(), {}};
  const auto on_one = try_cpus(options, find_one_cpu());
  if (!on_one) return tl::unexpected(on_one.error());
  const auto on_two = try_cpus(options, two_cpus);
  if (!on_two) return tl::unexpected(on_two.error());
  const NodeCpus chosen = should_use_two(*on_one, *on_two) ? two_cpus : find_one_cpu();
  return CpuChoice{chosen, describe_choice(chosen, *on_one, *on_two)};
}

Result<LatencyRun> run_latency(const LatencyRunOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) {
    return fail("{}: cannot be made: {}", options.out.string(), error.message());
  }
  const bool is_here = options.hosts.empty();
  const std::filesystem::path scene = find_scene(options.scene);
  if (is_here && !std::filesystem::exists(scene)) {
    return fail("{}: there is no such scene here; name one with --scene", options.scene.string());
  }
  // An interrupt reaches the nodes as well: they end, and the hub writes its report so far, which is used as the result.
  const StopSignal interrupts;
  Result<BareTimer> timer;
  std::string cpu_text;
  if (is_here) {
    const auto chosen = choose_cpus(options);
    if (!chosen) return tl::unexpected(chosen.error());
    if (interrupts.stop_requested())
      return fail("interrupted while the CPUs of the nodes were chosen; name them with --cpu to leave that out");
    if (!chosen->text.empty()) cpu_text = chosen->text + "\n";
    timer = measure_between_timers(options, chosen->cpus);
  } else if (const auto measured = measure_hub(options, interrupts); !measured) {
    timer = tl::unexpected(measured.error());
  }
  if (!timer) {
    return tl::unexpected(timer.error());
  }
  auto run = make_report(options.out / "report.json", is_here ? &*timer : nullptr);
  if (!run) {
    return run;
  }
  const auto picture = draw_latency_plot(options.out);
  run->text += cpu_text;
  run->text += fmt::format("report in {}; {}\n", options.out.string(), picture ? "plot in " + picture->string() : picture.error().what);
  if (const auto written = write_file_atomically(options.out / "latency.txt", run->text); !written) {
    return tl::unexpected(written.error());
  }
  return run;
}

}  // namespace hapton
