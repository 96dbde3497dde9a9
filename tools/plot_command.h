#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton plot DIR: draws DIR/latency.png from DIR/latency.csv with gnuplot.
void add_plot_command(CommandLine app, int& exit_code);

}  // namespace hapton
