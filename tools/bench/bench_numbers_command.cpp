#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/haptons/hapton_run.h"
#include "bench/measure/numbers_run.h"
#include "bench/peers/peer_structures.h"
#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "runtime/realtime.h"
#include "tools/bench/bench_meshes.h"
#include "tools/commands.h"
#include "tools/latency/latency_compare.h"
#include "tools/latency/latency_run.h"

namespace hapton {
namespace {

struct NumbersOptions {
  std::filesystem::path out = "out/numbers";
  std::string folder;
  std::vector<std::string> files;
  std::size_t seeds = 6;
  NumbersSettings settings;
  bool quick = false;
};

// Another part of the bench measures the haptons, the unit of the memo, in the same run.
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

// Runs three programs from the folder of this program. The folder on a gateway may lack one; the note then says why nothing is measured.
void fill_in_round_trip(const NumbersOptions& options, NumbersReport& report) {
  LatencyRunOptions run_options;
  run_options.seconds = options.quick ? 3.0 : 10.0;
  run_options.out = options.out / "latency";
  run_options.scene = find_mesh_folder().parent_path() / "scenes" / "car_front.toml";
  run_options.cpu = find_shared_cpu();
  const auto run_result = run_latency(run_options);
  const auto json = run_result ? read_report_json(run_options.out) : tl::unexpected(run_result.error());
  for (NumberRow& row : report.rows) {
    if (row.what != kRoundTripRow) continue;
    if (!json) {
      row.note = "could not be measured: " + json.error().what;
      continue;
    }
    row.ours = json->at("ratios").at("round_trip_over_echo_p50").get<double>();
    row.note = fmt::format("p50 over p50, {:g} s at 1 kHz; round trip {:.1f} us; see hapton latency", run_options.seconds,
                           json->at("hops").at("round_trip").at("p50_us").get<double>());
  }
}

// Loads the meshes that the options name or, if they name none, every mesh of the project.
Result<std::vector<NamedMesh>> load_meshes(const NumbersOptions& options) {
  const std::filesystem::path folder = options.folder.empty() ? find_mesh_folder() : std::filesystem::path(options.folder);
  std::vector<std::string> files = options.files;
  if (files.empty()) files = find_mesh_files(folder);
  std::vector<NamedMesh> meshes;
  for (const std::string& file : files) {
    auto mesh = make_bench_mesh(file, folder);
    if (!mesh) return tl::unexpected(mesh.error());
    meshes.push_back({std::move(mesh->name), std::move(mesh->mesh)});
  }
  return meshes;
}

Result<void> measure(NumbersOptions& options) {
  if (auto writable = ensure_writable_folder(options.out); !writable) return writable;
  if (options.quick) {
    options.settings.ladder = {5000, 80000};
    options.settings.steps = std::min<std::size_t>(options.settings.steps, 4000);
    options.settings.compared_steps = 600;
    options.settings.scale_exponents = {-6, 0, 6};
    options.settings.budget = {.repetitions = 3, .seconds = 0.3};
    options.settings.rough_triangles = 80000;
    options.settings.meshes.steps = std::min<std::size_t>(options.settings.meshes.steps, 2000);
    options.settings.meshes.windows = 1;
    options.seeds = std::min<std::size_t>(options.seeds, 2);
  }
  options.settings.meshes.seeds.clear();
  for (std::size_t i = 0; i < options.seeds; ++i) options.settings.meshes.seeds.push_back(options.settings.seed + i);
  const auto meshes = load_meshes(options);
  if (!meshes) return tl::unexpected(meshes.error());
  const Stopwatch watch = Stopwatch::calibrate();
  const SteadyClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const Progress progress = [&](const std::string& what) { print_progress(1e-9 * static_cast<double>(clock.now_ns() - start_ns), what); };
  auto report = measure_numbers(options.settings, watch, peer_structures(), *meshes, progress);
  if (!report) return tl::unexpected(report.error());
  report->conditions.missing_peers = missing_peers();
  progress("haptons");
  fill_in_haptons(options, *report);
  progress("force round trip");
  fill_in_round_trip(options, *report);
  const std::string text = to_text(*report);
  fmt::print("{}", text);
  if (options.quick) fmt::print("--quick: spheres of 82 k triangles stand for those of 1.3 M; the targets are those of the whole run.\n");
  if (auto written = write_file_atomically(options.out / "numbers.txt", text); !written) return written;
  if (auto written = write_file_atomically(options.out / "numbers.csv", to_csv(*report)); !written) return written;
  if (auto written = write_file_atomically(options.out / "meshes.csv", to_csv(report->meshes)); !written) return written;
  if (auto written = write_file_atomically(options.out / "switches.csv", switches_to_csv(report->meshes)); !written) return written;
  return write_file_atomically(options.out / "numbers.json", to_json(*report));
}

}  // namespace

void add_bench_numbers_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<NumbersOptions>();
  const auto add_options = [&](CommandLine command) {
    command.add_flag("--quick", options->quick, "Smaller spheres, short runs, two seeds: about a minute");
    command.add_option("--mesh", options->files, "Only these meshes, and both spheres (default: every mesh of the folder)");
    command.add_option("--meshes-in", options->folder, "The mesh folder (default: ./meshes, else the source tree's)");
    command.add_option("--steps", options->settings.steps, "Steps of each trajectory").between(100, 10'000'000).shows_default();
    command.add_option("--mesh-steps", options->settings.meshes.steps, "Steps of each slide over each mesh")
        .between(300, 10'000'000)
        .shows_default();
    command.add_option("--seeds", options->seeds, "Slides over each mesh").between(1, 1000).shows_default();
    command.add_option("--windows", options->settings.meshes.windows, "Windows of each slide that are compared with the reference")
        .between(1, 10000)
        .shows_default();
    command.add_option("--window-steps", options->settings.meshes.window_steps, "Steps of each window").between(2, 4000).shows_default();
    const CommandOption compared =
        command.add_option("--compared-steps", options->settings.compared_steps, "Steps compared with the reference at every scale")
            .between(10, 10'000'000)
            .shows_default();
    command.add_old_option("--judged-steps", compared);
    command.add_option("--seed", options->settings.seed, "Seed of meshes and trajectories").shows_default();
    command.add_option("--out", options->out, "Folder for numbers.txt, numbers.csv, meshes.csv, switches.csv and numbers.json")
        .folder_to_write()
        .shows_default();
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
