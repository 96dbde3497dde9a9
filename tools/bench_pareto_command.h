#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton bench pareto: run time against force error of every method and structure, with a plot.
void add_bench_pareto_command(CLI::App& bench, int& exit_code);

}  // namespace hapton
