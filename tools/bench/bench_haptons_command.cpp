#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "bench/haptons/hapton_run.h"
#include "runtime/atomic_file.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct HaptonsOptions {
  HaptonRunSettings settings;
  std::string out;
};

Result<void> write(const HaptonRun& run, const std::filesystem::path& folder) {
  if (auto written = write_file_atomically(folder / "haptons.json", to_json(run)); !written) return written;
  return write_file_atomically(folder / "haptons.csv", to_csv(run));
}

int run_haptons(const HaptonsOptions& options) {
  const HaptonRun run = measure_haptons(options.settings);
  fmt::print("{}", to_text(run));
  if (!options.out.empty()) {
    if (const auto written = write(run, options.out); !written) {
      fmt::print(stderr, "hapton bench haptons: {}\n", written.error().what);
      return 1;
    }
    fmt::print("\n{}/haptons.json and haptons.csv written\n", options.out);
  }
  if (run.holds()) return 0;
  fmt::print(stderr,
             "hapton bench haptons: not every pair was located to 0.1 %, so these rates do not count as haptons; see the columns missed "
             "and > 0.1 %\n");
  return 1;
}

}  // namespace

void add_bench_haptons_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<HaptonsOptions>();
  const CommandLine command =
      bench.add_subcommand("haptons", "Triangle pairs a millisecond on one core, colliding on edge, located to 0.1 %");
  command.add_option("--seconds", options->settings.seconds, "Duration of all measurements together, s")
      .between(0.01, 3600.0)
      .shows_default();
  command.add_option("--seed", options->settings.pairs.seed, "Seed of the random pairs").shows_default();
  command.add_option("--out", options->out, "Folder for haptons.json and haptons.csv; default: none are written").folder_to_write();
  command.on_run([options, &exit_code] { exit_code = run_haptons(*options); });
}

}  // namespace hapton
