#include "tools/soak/soak_run.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "runtime/stop_signal.h"
#include "tools/json_number.h"
#include "tools/live/hub_report.h"
#include "tools/live/top_view.h"
#include "tools/local_node.h"
#include "tools/soak/soak_plot.h"
#include "tools/soak/soak_verdict.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSamplesInARun = 120.0;      // observations in a run of any length; a free choice
constexpr double kShortestIntervalS = 2.0;    // between observations, s; a free choice
constexpr double kPollPeriodS = 0.1;          // the longest sleep before a stop is noticed, s; a free choice
constexpr double kProgressEveryS = 10.0;      // least time between two progress lines, s; a free choice
constexpr double kMaxProgressLines = 60.0;    // most progress lines in a run of any length; a free choice
constexpr double kFirstForceTimeoutS = 30.0;  // longest wait for the first force, s: large meshes need it; a free choice

// The nodes of this run.
struct Nodes {
  std::vector<LocalNode> nodes;  // io_node last: the others leave the session before it ends
  LocalVision vision;
  bool has_vision = false;
  std::string hub_address;

  std::vector<LocalNode*> all() {
    std::vector<LocalNode*> all;
    for (LocalNode& node : nodes) all.push_back(&node);
    if (has_vision) all.push_back(&vision.node());
    return all;
  }

  Result<void> check_running() {
    for (LocalNode* node : all()) {
      if (const auto running = node->check_running(); !running) return running;
    }
    return {};
  }

  Result<void> stop() {
    Result<void> ended = vision.stop();
    for (LocalNode& node : nodes) {
      if (const auto stopped = node.stop(); !stopped && ended) ended = stopped;
    }
    return ended;
  }
};

Result<void> start_nodes(const SoakOptions& options, Nodes& nodes) {
  const auto hub_address = find_free_address();
  if (!hub_address) return tl::unexpected(hub_address.error());
  nodes.hub_address = *hub_address;
  std::vector<std::string> key;
  if (!options.key_file.empty()) key = {"--key", options.key_file};
  const auto start = [&](const std::string& name, std::vector<std::string> words, const std::string& ready) -> Result<void> {
    words.insert(words.end(), {"--rt", options.realtime, "--cpu", fmt::format("{}", options.cpu)});
    words.insert(words.end(), key.begin(), key.end());
    auto node = LocalNode::start(options.out, name, find_own_folder() / name, std::move(words));
    if (!node) return tl::unexpected(node.error());
    nodes.nodes.push_back(std::move(*node));
    return nodes.nodes.back().wait_for(ready);
  };
  nodes.nodes.reserve(2);
  std::vector<std::string> haptics = {"--hub", *hub_address, "--scene", options.scene.string()};
  std::vector<std::string> io = {"--bind", *hub_address, "--rate", fmt::format("{}", options.rate_hz), "--out", options.out.string()};
  if (options.cpu >= 0) {  // on one CPU a node that spins would take the time that the other needs
    haptics.insert(haptics.end(), {"--spin", "0"});
    io.insert(io.end(), {"--spin-reply", "0"});
  }
  if (const auto started = start("haptics_node", std::move(haptics), "ready"); !started) return started;
  if (const auto started = start("io_node", std::move(io), "hub on "); !started) return started;
  if (!options.vision) return {};
  std::vector<std::string> words = {"--hub", *hub_address, "--scene", options.scene.string()};
  words.insert(words.end(), key.begin(), key.end());
  if (const auto started = nodes.vision.start(options.out, std::move(words)); !started) return started;
  nodes.has_vision = true;
  return {};
}

std::int64_t counter(const Json& report, const char* name) { return static_cast<std::int64_t>(json_number_of(report, "counters", name)); }

// Samples the nodes, and compares each sample with the first and the previous one.
class NodeSampler {
 public:
  NodeSampler(const SoakOptions& options, Nodes& nodes, std::unique_ptr<HubReader> reader)
      : rate_hz_(options.rate_hz), nodes_(nodes), reader_(std::move(reader)) {}

  // Reads the hub until it has counted a force, and with --vision also a frame.
  Result<void> wait_for_force(const StopSignal& stop) {
    const double end_s = now_s() + kFirstForceTimeoutS;
    while (now_s() < end_s && !stop.stop_requested()) {
      auto reading = read();
      if (!reading) return tl::unexpected(reading.error());
      if (counter(reading->snapshot.report, "forces") > 0 && (!nodes_.has_vision || counter(reading->snapshot.report, "drawn") > 0)) {
        first_ = last_ = std::move(*reading);
        return {};
      }
      if (const auto running = nodes_.check_running(); !running) return running;
      idle(kPollPeriodS);
    }
    return fail("no force (or, with --vision, no frame) within {:g} s; see the logs", kFirstForceTimeoutS);
  }

  double seconds() const { return now_s() - first_->time_s; }
  void idle(double seconds) { reader_->idle(seconds); }

  Result<SoakSample> sample() {
    auto reading = read();
    if (!reading) return tl::unexpected(reading.error());
    SoakSample sample;
    sample.seconds = reading->time_s - first_->time_s;
    const double passed_s = json_number_of(reading->snapshot.report, "seconds") - json_number_of(last_->snapshot.report, "seconds");
    const auto rate = [&](const char* name) {
      return passed_s > 0.0
                 ? static_cast<double>(counter(reading->snapshot.report, name) - counter(last_->snapshot.report, name)) / passed_s
                 : 0.0;
    };
    const auto since_first = [&](const char* name) {
      return counter(reading->snapshot.report, name) - counter(first_->snapshot.report, name);
    };
    sample.samples_hz = rate("samples");
    sample.forces_hz = rate("forces");
    sample.contacts_hz = rate("contact_samples");
    sample.drawn_hz = rate("drawn");
    sample.lost = since_first("lost");
    sample.late = since_first("late");
    sample.superseded = since_first("superseded");
    sample.missed_cycles = since_first("missed_cycles");
    sample.drift_ms = 1e3 * (static_cast<double>(since_first("samples") + sample.missed_cycles) / rate_hz_ - sample.seconds);
    for (const HopCounts& hop : subtract_hops(reading->snapshot.hops, last_->snapshot.hops)) {
      if (hop.name != "round_trip" || hop.total() == 0) continue;
      sample.round_trip_p50_us = hop.quantile_us(0.5);
      sample.round_trip_p99_us = hop.quantile_us(0.99);
      sample.round_trip_max_us = hop.quantile_us(1.0);
    }
    for (LocalNode* node : nodes_.all()) {
      const auto stats = read_process_stats(node->pid());
      if (!stats) return tl::unexpected(stats.error());
      sample.processes.push_back(*stats);
    }
    last_ = std::move(*reading);
    return sample;
  }

 private:
  struct Reading {
    double time_s = 0.0;
    TopSnapshot snapshot;
  };

  double now_s() const { return 1e-9 * static_cast<double>(clock_.now_ns()); }

  Result<Reading> read() {
    const double time_s = now_s();
    const auto texts = reader_->read();
    if (!texts) return tl::unexpected(texts.error());
    auto snapshot = read_top_snapshot(texts->json, texts->csv);
    if (!snapshot) return tl::unexpected(snapshot.error());
    return Reading{time_s, std::move(*snapshot)};
  }

  SteadyClock clock_;
  double rate_hz_;
  Nodes& nodes_;
  std::unique_ptr<HubReader> reader_;
  std::optional<Reading> first_;
  std::optional<Reading> last_;
};

void print_progress(const SoakRun& run) {
  const SoakSample& sample = run.samples.back();
  std::string memory;
  for (std::size_t i = 0; i < run.processes.size(); ++i) {
    memory += fmt::format(", {} {:.1f} MiB {} fd", run.processes[i], static_cast<double>(sample.processes[i].resident_kib) / 1024.0,
                          sample.processes[i].descriptors);
  }
  fmt::print("soak: {:.0f} of {:.0f} s: {:.0f} forces/s, {} lost, {} late, {} missed, round trip p50 {:.0f} p99 {:.0f} max {:.0f} us{}\n",
             sample.seconds, run.seconds, sample.forces_hz, sample.lost, sample.late, sample.missed_cycles, sample.round_trip_p50_us,
             sample.round_trip_p99_us, sample.round_trip_max_us, memory);
  std::fflush(stdout);
}

// Samples until the time is over, a node ends or a stop is requested; run.end_reason says why, empty after the full time.
Result<void> sample_nodes(const SoakOptions& options, Nodes& nodes, NodeSampler& sampler, const StopSignal& stop, SoakRun& run) {
  const std::filesystem::path table = options.out / "soak.csv";
  std::ofstream csv(table);
  csv << soak_csv_header(run.processes) << std::flush;
  const double every_s = sample_interval_s(options);
  double due_s = every_s;
  double next_progress_s = 0.0;
  while (due_s <= options.seconds + 1e-6) {
    while (sampler.seconds() < due_s && run.end_reason.empty()) {
      sampler.idle(std::clamp(due_s - sampler.seconds(), 0.0, kPollPeriodS));
      if (const auto running = nodes.check_running(); !running) run.end_reason = running.error().what;
      if (stop.stop_requested()) run.end_reason = "stopped early";
    }
    if (!run.end_reason.empty()) return {};
    auto sample = sampler.sample();
    if (!sample) {
      const auto running = nodes.check_running();
      run.end_reason = running ? sample.error().what : running.error().what;
      return {};
    }
    run.samples.push_back(std::move(*sample));
    if (!(csv << soak_csv_row(run.samples.back()) << std::flush)) return fail("{}: cannot be written", table.string());
    if (due_s >= next_progress_s) {
      print_progress(run);
      next_progress_s = due_s + std::max(kProgressEveryS, options.seconds / kMaxProgressLines);
    }
    due_s += every_s;
  }
  return {};
}

Result<SoakRun> soak(const SoakOptions& options) {
  const StopSignal stop;
  Nodes nodes;
  if (const auto started = start_nodes(options, nodes); !started) return tl::unexpected(started.error());
  auto reader = HubReader::open(nodes.hub_address, options.key_file);
  if (!reader) return tl::unexpected(reader.error());
  NodeSampler sampler(options, nodes, std::move(*reader));
  if (const auto force = sampler.wait_for_force(stop); !force) return tl::unexpected(force.error());
  SoakRun run{.seconds = options.seconds, .rate_hz = options.rate_hz, .processes = {}, .samples = {}, .end_reason = {}};
  for (const LocalNode* node : nodes.all()) run.processes.push_back(node->name());
  if (const auto watched = sample_nodes(options, nodes, sampler, stop, run); !watched) return tl::unexpected(watched.error());
  if (const auto stopped = nodes.stop(); !stopped && run.end_reason.empty()) run.end_reason = stopped.error().what;
  return run;
}

}  // namespace

double sample_interval_s(const SoakOptions& options) {
  return options.every_s > 0.0 ? options.every_s : std::max(kShortestIntervalS, options.seconds / kSamplesInARun);
}

Result<SoakEnd> run_soak(const SoakOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) return fail("{}: cannot be made: {}", options.out.string(), error.message());
  const auto run = soak(options);
  if (!run) return tl::unexpected(run.error());
  const SoakVerdict verdict = evaluate_soak(*run);
  if (const auto written = write_file_atomically(options.out / "soak.json",
                                                 to_json(*run, verdict).dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
      !written) {
    return tl::unexpected(written.error());
  }
  const auto picture = run->samples.empty() ? Result<std::filesystem::path>(fail("no observation was made, so no plot is drawn"))
                                            : draw_soak_plot(options.out, run->processes);
  return SoakEnd{fmt::format("soak: observations in {}, {}\n{}\n", (options.out / "soak.csv").string(),
                             picture ? "plot in " + picture->string() : picture.error().what, to_text(*run, verdict)),
                 verdict.is_flat};
}

}  // namespace hapton
