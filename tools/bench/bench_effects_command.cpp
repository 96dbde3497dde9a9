#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "bench/measure/effects_run.h"
#include "tools/bench/bench_report.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct EffectsOptions {
  EffectsSettings settings;
  std::string out;
  bool quick = false;
};

Result<void> measure_all_effects(EffectsOptions& options) {
  if (options.quick) {
    options.settings.steps = 2000;
    options.settings.budget = {.repetitions = 3, .seconds = 0.3};
  }
  const Stopwatch watch = Stopwatch::calibrate();
  return measure_and_report(options.out, "effects",
                            [&](const auto& progress) { return measure_effects(options.settings, watch, progress); });
}

}  // namespace

void add_bench_effects_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<EffectsOptions>();
  const CommandLine command =
      bench.add_subcommand("effects", "What each effect of docs/effects.md adds to a step, and how far its force is from its formula");
  command.add_flag("--quick", options->quick, "Short runs");
  command.add_option("--steps", options->settings.steps, "Steps of the slide").between(100, 10'000'000).shows_default();
  command.add_option("--seed", options->settings.seed, "Seed of the slide").shows_default();
  command.add_option("--out", options->out, "Folder for effects.txt, effects.csv and effects.json; default: none are written")
      .folder_to_write();
  command.on_run([options, &exit_code] {
    const auto done = measure_all_effects(*options);
    if (!done) fmt::print(stderr, "hapton bench effects: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
