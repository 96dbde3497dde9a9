#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "bench/measure/sculpt_run.h"
#include "tools/bench/bench_report.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct SculptBenchOptions {
  SculptRunSettings settings;
  std::size_t seeds = 2;
  std::string out;
  bool quick = false;
};

Result<void> measure_all_sculpting(SculptBenchOptions& options) {
  SculptRunSettings& settings = options.settings;
  settings.seeds.clear();
  for (std::size_t seed = 1; seed <= options.seeds; ++seed) settings.seeds.push_back(seed);
  if (options.quick) {
    settings.grids = {64};
    settings.seeds = {1};
    settings.steps = 3000;
    settings.budget = {.repetitions = 2, .seconds = 1.0};
  }
  const Stopwatch watch = Stopwatch::calibrate();
  return measure_and_report(options.out, "sculpt", [&](const auto& progress) { return measure_sculpting(settings, watch, progress); });
}

}  // namespace

void add_bench_sculpt_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<SculptBenchOptions>();
  const CommandLine command = bench.add_subcommand("sculpt", "Steps that carve and touch carved bodies, and their surface");
  command.add_flag("--quick", options->quick, "Short runs");
  command.add_option("--steps", options->settings.steps, "Steps of each motion").between(100, 10'000'000).shows_default();
  command.add_option("--seeds", options->seeds, "Motions of each body and ball, from seed 1 on").between(1, 1000).shows_default();
  command.add_option("--out", options->out, "Folder for sculpt.txt, sculpt.csv and sculpt.json; default: none are written")
      .folder_to_write();
  command.on_run([options, &exit_code] {
    const auto done = measure_all_sculpting(*options);
    if (!done) fmt::print(stderr, "hapton bench sculpt: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
