#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "bench/measure/sixdof_run.h"
#include "bench/peers/tool_peers.h"
#include "core/base/worker_team.h"
#include "tools/bench/bench_report.h"
#include "tools/bench/sixdof_plot.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct SixdofOptions {
  SixdofSettings settings;
  std::string out;
  bool quick = false;
  bool proxy_only = false;
  int threads = 1;
};

Result<void> measure_all_tools(SixdofOptions& options) {
  if (options.quick) {
    options.settings.steps = 1000;
    options.settings.peg_steps = 2000;
    options.settings.budget = {.repetitions = 1, .seconds = 1.0};
    options.settings.with_large = false;
  }
  if (options.threads > 1) options.settings.compared.push_back(proxy_tool(options.threads));
  if (!options.proxy_only) {
    for (const double voxel_m : {1e-3, 5e-4, 2.5e-4}) options.settings.compared.push_back(voxel_tool(voxel_m));
    for (SixdofMethodKind& peer : tool_peers()) options.settings.compared.push_back(std::move(peer));
  }
  const Stopwatch watch = Stopwatch::calibrate();
  std::vector<SixdofRow> rows;
  auto done = measure_and_report(options.out, "sixdof", [&](const auto& progress) {
    auto report = measure_sixdof(options.settings, watch, progress);
    if (report) {
      rows = report->rows;
      if (!options.proxy_only) report->conditions.missing_peers = missing_tool_peers();
    }
    return report;
  });
  if (!done || options.out.empty()) return done;
  const auto picture = draw_sixdof_plot(options.out, rows);
  if (!picture) return tl::unexpected(picture.error());
  fmt::print("picture: {}\n", picture->string());
  return {};
}

}  // namespace

void add_bench_sixdof_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<SixdofOptions>();
  const CommandLine command = bench.add_subcommand("sixdof", "A rigid tool: force and torque against theory, gaps, run time");
  command.add_flag("--quick", options->quick, "Short runs, without the largest scene");
  command.add_option("--steps", options->settings.steps, "Steps of each scenario").between(100, 10'000'000).shows_default();
  command.add_option("--peg-steps", options->settings.peg_steps, "Steps of the peg with 20 um of clearance")
      .between(100, 10'000'000)
      .shows_default();
  command.add_option("--seed", options->settings.seed, "Seed of the motions and of the bumpy bodies").shows_default();
  command.add_flag("--proxy-only", options->proxy_only, "Measure only the proxy, without voxels and other libraries");
  command.add_option("--threads", options->threads, "Measure the tool with this number of threads as well")
      .between(1, WorkerTeam::kMaxWorkers)
      .shows_default();
  command.add_option("--out", options->out, "Folder for sixdof.txt, sixdof.csv, sixdof.json and sixdof.png; default: none are written")
      .folder_to_write();
  command.on_run([options, &exit_code] {
    const auto done = measure_all_tools(*options);
    if (!done) fmt::print(stderr, "hapton bench sixdof: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
