#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "tools/commands.h"
#include "tools/figures/figures.h"
#include "tools/gnuplot.h"

namespace hapton {
namespace {

Result<void> draw_all(const std::filesystem::path& folder) {
  const auto figures = make_figures();
  if (!figures) return tl::unexpected(figures.error());
  for (const Figure& figure : *figures) {
    const auto picture = draw_with_gnuplot(folder, figure.name + ".png", figure.script);
    if (!picture) return tl::unexpected(picture.error());
    fmt::print("{}\n", picture->string());
  }
  return {};
}

}  // namespace

void add_figures_command(CommandLine app, int& exit_code) {
  auto folder = std::make_shared<std::string>("docs/pictures");
  const CommandLine command = app.add_subcommand("figures", "Draw the pictures of docs/methods.md; the methods compute what they show");
  command.add_option("--out", *folder, "Folder to write the pictures to").folder_to_write().shows_default();
  command.on_run([folder, &exit_code] {
    const auto drawn = draw_all(*folder);
    if (!drawn) fmt::print(stderr, "hapton figures: {}\n", drawn.error().what);
    exit_code = drawn ? 0 : 1;
  });
}

}  // namespace hapton
