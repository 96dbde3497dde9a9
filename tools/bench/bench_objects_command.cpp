#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "bench/measure/objects_run.h"
#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "tools/bench/bench_meshes.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct ObjectsOptions {
  ObjectsSettings settings;
  std::string out;
  bool quick = false;
};

Result<void> measure(ObjectsOptions& options) {
  if (!options.out.empty()) {
    if (auto writable = check_writable(options.out); !writable) return writable;
  }
  if (options.quick) {
    options.settings.steps = 2000;
    options.settings.budget = {.repetitions = 3, .seconds = 0.3};
  }
  const Stopwatch watch = Stopwatch::calibrate();
  const SteadyClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const auto report = measure_objects(options.settings, watch, [&](const std::string& what) {
    print_progress(1e-9 * static_cast<double>(clock.now_ns() - start_ns), what);
  });
  if (!report) return tl::unexpected(report.error());
  fmt::print("{}", to_text(*report));
  if (options.out.empty()) return {};
  const std::filesystem::path folder = options.out;
  if (auto written = write_file_atomically(folder / "objects.csv", to_csv(*report)); !written) return written;
  if (auto written = write_file_atomically(folder / "objects.txt", to_text(*report)); !written) return written;
  return write_file_atomically(folder / "objects.json", to_json(*report));
}

}  // namespace

void add_bench_objects_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<ObjectsOptions>();
  const CommandLine command =
      bench.add_subcommand("objects", "A step in scenes of 1 to 1,000 objects, 1 M triangles in all, beside the touched object alone");
  command.add_flag("--quick", options->quick, "Short runs");
  command.add_option("--triangles", options->settings.triangles, "Triangles of all objects together, about")
      .between(18'000, 20'000'000)
      .shows_default();
  command.add_option("--steps", options->settings.steps, "Steps of each trajectory").between(100, 10'000'000).shows_default();
  command.add_option("--seed", options->settings.seed, "Seed of the trajectories").shows_default();
  command.add_option("--out", options->out, "Folder for objects.txt, objects.csv and objects.json; default: none are written")
      .folder_to_write();
  command.on_run([options, &exit_code] {
    const auto done = measure(*options);
    if (!done) fmt::print(stderr, "hapton bench objects: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
