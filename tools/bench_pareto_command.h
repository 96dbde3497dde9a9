#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton bench pareto: run time against force error of every method and structure, with a plot.
void add_bench_pareto_command(CommandLine bench, int& exit_code);

}  // namespace hapton
