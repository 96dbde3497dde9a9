#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "tools/commands.h"
#include "tools/latency/latency_plot.h"

namespace hapton {
namespace {

int run(const std::string& folder) {
  const auto picture = draw_latency_plot(folder);
  if (!picture) {
    fmt::print(stderr, "hapton plot: {}\n", picture.error().what);
    return 1;
  }
  fmt::print("{}\n", picture->string());
  return 0;
}

}  // namespace

void add_plot_command(CommandLine app, int& exit_code) {
  auto folder = std::make_shared<std::string>();
  const CommandLine command = app.add_subcommand("plot", "Draw the plots of a run's report folder");
  command.add_option("folder", *folder, "Folder with latency.csv; latency.png is written there").required();
  command.on_run([folder, &exit_code] { exit_code = run(*folder); });
}

}  // namespace hapton
