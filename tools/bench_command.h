#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton bench: the parent of all measurements; each child has a file of its own, tools/bench_<name>_command.
void add_bench_command(CLI::App& app, int& exit_code);

}  // namespace hapton
