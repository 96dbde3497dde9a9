#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton figures --out DIR: draws the pictures of docs/methods.md with gnuplot.
void add_figures_command(CLI::App& app, int& exit_code);

}  // namespace hapton
