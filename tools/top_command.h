#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton top [--hub HOST:PORT] [--once] [--interval S]: a running system's nodes, rates, latencies and counters, in the terminal.
void add_top_command(CLI::App& app, int& exit_code);

}  // namespace hapton
