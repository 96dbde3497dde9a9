#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton bench numbers: the numbers to beat, target and ours side by side, in one run.
void add_bench_numbers_command(CLI::App& bench, int& exit_code);

}  // namespace hapton
