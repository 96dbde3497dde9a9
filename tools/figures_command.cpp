#include "tools/figures_command.h"

#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "runtime/atomic_file.h"
#include "tools/child_process.h"
#include "tools/figures.h"

namespace hapton {
namespace {

constexpr double kDrawSeconds = 60.0;

Result<void> draw(const Figure& figure, const std::filesystem::path& folder) {
  const std::string program = figure.name + ".gnuplot.part";
  if (auto written = write_file_atomically(folder / program, figure.script); !written) return written;
  auto gnuplot = ChildProcess::start({.program = "gnuplot", .arguments = {program}, .folder = folder, .output = {}});
  const auto code = gnuplot ? gnuplot->wait(kDrawSeconds) : std::optional<int>(127);
  std::error_code ignored;
  std::filesystem::remove(folder / program, ignored);
  if (code == 127) return fail("gnuplot cannot be started, so nothing is drawn; install the package gnuplot-nox");
  const std::filesystem::path part = folder / (figure.name + ".png.part");
  if (code != 0) {
    std::filesystem::remove(part, ignored);
    return fail("gnuplot could not draw {}.png; what it said stands above", figure.name);
  }
  std::error_code error;
  std::filesystem::rename(part, folder / (figure.name + ".png"), error);
  if (error) return fail("{}: cannot be written: {}", (folder / (figure.name + ".png")).string(), error.message());
  return {};
}

Result<void> draw_all(const std::filesystem::path& folder) {
  const auto figures = make_figures();
  if (!figures) return tl::unexpected(figures.error());
  for (const Figure& figure : *figures) {
    if (auto drawn = draw(figure, folder); !drawn) return drawn;
    fmt::print("{}\n", (folder / (figure.name + ".png")).string());
  }
  return {};
}

}  // namespace

void add_figures_command(CommandLine app, int& exit_code) {
  auto folder = std::make_shared<std::string>("docs/pictures");
  const CommandLine command = app.add_subcommand("figures", "Draw the pictures of docs/methods.md from what the methods do");
  command.add_option("--out", *folder, "Folder of the pictures").shows_default();
  command.on_run([folder, &exit_code] {
    const auto drawn = draw_all(*folder);
    if (!drawn) fmt::print(stderr, "hapton figures: {}\n", drawn.error().what);
    exit_code = drawn ? 0 : 1;
  });
}

}  // namespace hapton
