#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton figures --out DIR: draws the pictures of docs/methods.md with gnuplot.
void add_figures_command(CommandLine app, int& exit_code);

}  // namespace hapton
