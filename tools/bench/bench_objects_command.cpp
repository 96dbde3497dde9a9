#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "bench/measure/objects_run.h"
#include "tools/bench/bench_report.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct ObjectsOptions {
  ObjectsSettings settings;
  std::string out;
  bool quick = false;
};

Result<void> measure(ObjectsOptions& options) {
  if (options.quick) {
    options.settings.steps = 2000;
    options.settings.budget = {.repetitions = 3, .seconds = 0.3};
  }
  const Stopwatch watch = Stopwatch::calibrate();
  return measure_and_report(options.out, "objects",
                            [&](const auto& progress) { return measure_objects(options.settings, watch, progress); });
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
