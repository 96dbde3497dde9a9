#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton plot DIR: draws DIR/latency.png from DIR/latency.csv with gnuplot.
void add_plot_command(CLI::App& app, int& exit_code);

}  // namespace hapton
