#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "tools/commands.h"
#include "tools/latency/latency_compare.h"
#include "tools/latency/run_summary.h"

namespace hapton {
namespace {

struct SummaryOptions {
  std::string folder;
  std::string scene = "the scene";
};

int run(const SummaryOptions& options) {
  const auto report = read_report_json(options.folder);
  if (!report) {
    fmt::print(stderr, "hapton summary: {}\n", report.error().what);
    return 1;
  }
  fmt::print("{}", summarise_run(*report, options.scene).text);
  return 0;
}

}  // namespace

void add_summary_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<SummaryOptions>();
  const CommandLine command =
      app.add_subcommand("summary", "Print in two lines what a run touched, and whether it kept its rate without faults");
  command.add_option("folder", options->folder, "Folder with the run's report.json, or that file").required();
  command.add_option("--scene", options->scene, "Scene of the run, to name it in the text");
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
