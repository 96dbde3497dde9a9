#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton latency [--seconds N] [--rate HZ] [--out DIR]: starts io_node and haptics_node on this machine, beside a bare echo, and reports
// the force round trip, its hops, and its ratio to the bare echo of the same run.
void add_latency_command(CLI::App& app, int& exit_code);

}  // namespace hapton
