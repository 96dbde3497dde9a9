#include "tools/bench_numbers_command.h"

#include <fmt/core.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/haptons/hapton_run.h"
#include "bench/measure/numbers_run.h"
#include "bench/peers/peer_structures.h"
#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "runtime/realtime.h"
#include "tools/bench_meshes.h"
#include "tools/latency_compare.h"
#include "tools/latency_run.h"

namespace hapton {
namespace {

struct NumbersOptions {
  std::filesystem::path out = "out/numbers";
  std::string folder;
  std::string file = "nefertiti_70k.ply";
  NumbersSettings settings;
  bool quick = false;
};

// The memo's unit is measured by another part of the bench, in the same run.
void fill_in_haptons(const NumbersOptions& options, NumbersReport& report) {
  HaptonRunSettings settings;
  settings.pairs.seed = options.settings.seed;
  settings.seconds = options.quick ? 1.0 : 5.0;
  const HaptonRun run = measure_haptons(settings);
  for (NumberRow& row : report.rows) {
    if (row.what != kHaptonsRow) continue;
    for (const HaptonResult& result : run.results) {
      if (result.is_peer) row.peers.emplace_back(result.name, result.p50_haptons);
      if (!result.is_peer && result.holds() && result.p50_haptons > row.ours.value_or(0.0)) {
        row.ours = result.p50_haptons;
        row.note = fmt::format("{}; p50 of batches, all {} pairs checked against extended precision", result.name, result.checked);
      }
    }
  }
}

// Three processes of this program's own folder, where they are built: a gateway's may lack one.
void fill_in_round_trip(const NumbersOptions& options, NumbersReport& report) {
  LatencyRunOptions run;
  run.seconds = options.quick ? 3.0 : 10.0;
  run.out = options.out / "latency";
  run.scene = find_mesh_folder().parent_path() / "scenes" / "car_front.toml";
  run.cpu = find_shared_cpu();
  const auto ran = run_latency(run);
  const auto json = ran ? read_report_json(run.out) : tl::unexpected(ran.error());
  for (NumberRow& row : report.rows) {
    if (row.what != kRoundTripRow) continue;
    if (!json) {
      row.note = "could not be measured: " + json.error().what;
      continue;
    }
    row.ours = json->at("ratios").at("round_trip_over_echo_p50").get<double>();
    row.note = fmt::format("p50 over p50, {:g} s at 1 kHz; round trip {:.1f} us; hapton latency tells more", run.seconds,
                           json->at("hops").at("round_trip").at("p50_us").get<double>());
  }
}

Result<void> measure(NumbersOptions& options) {
  if (auto writable = check_writable(options.out); !writable) return writable;
  if (options.quick) {
    options.settings.ladder = {5000, 80000};
    options.settings.steps = 4000;
    options.settings.judged_steps = 600;
    options.settings.scale_exponents = {-6, 0, 6};
    options.settings.budget = {.repetitions = 3, .seconds = 0.3};
  }
  const auto mesh = make_bench_mesh(options.file, options.folder.empty() ? find_mesh_folder() : std::filesystem::path(options.folder));
  if (!mesh) return tl::unexpected(mesh.error());
  const Stopwatch watch = Stopwatch::calibrate();
  const SteadyClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const Progress progress = [&](const std::string& what) { print_progress(1e-9 * static_cast<double>(clock.now_ns() - start_ns), what); };
  auto report = measure_numbers(options.settings, watch, peer_structures(), mesh->mesh, mesh->name, progress);
  if (!report) return tl::unexpected(report.error());
  report->conditions.missing_peers = missing_peers();
  progress("haptons");
  fill_in_haptons(options, *report);
  progress("force round trip");
  fill_in_round_trip(options, *report);
  const std::string text = to_text(*report);
  fmt::print("{}", text);
  if (options.quick) fmt::print("--quick: a mesh of 82 k triangles stands for that of 1.3 M; the targets are those of the whole run.\n");
  if (auto written = write_file_atomically(options.out / "numbers.txt", text); !written) return written;
  if (auto written = write_file_atomically(options.out / "numbers.csv", to_csv(*report)); !written) return written;
  return write_file_atomically(options.out / "numbers.json", to_json(*report));
}

}  // namespace

void add_bench_numbers_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<NumbersOptions>();
  const auto add_options = [&](CommandLine command) {
    command.add_flag("--quick", options->quick, "Smaller meshes, short runs: less than a minute");
    command.add_option("--mesh", options->file, "A scanned mesh that the force error is measured on too").shows_default();
    command.add_option("--meshes-in", options->folder, "The mesh folder (default: ./meshes, else the source tree's)");
    command.add_option("--steps", options->settings.steps, "Of each trajectory").between(100, 10'000'000).shows_default();
    command.add_option("--judged-steps", options->settings.judged_steps, "Of them against the reference")
        .between(10, 10'000'000)
        .shows_default();
    command.add_option("--seed", options->settings.seed, "Of meshes and trajectories").shows_default();
    command.add_option("--out", options->out, "Folder for numbers.txt, numbers.csv and numbers.json").shows_default();
  };
  const auto run = [options, &exit_code] {
    const auto done = measure(*options);
    if (!done) fmt::print(stderr, "hapton bench numbers: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  };
  add_options(bench);
  const CommandLine command =
      bench.add_subcommand("numbers", "The numbers to beat: target, others and ours side by side; exits 0 whether or not they are met");
  add_options(command);
  command.on_run(run);
  bench.on_run([bench, run] {
    if (!bench.has_subcommand()) run();
  });
}

}  // namespace hapton
