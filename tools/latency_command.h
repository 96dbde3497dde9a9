#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton latency [run] [--seconds N] [--rate HZ] [--size B] [--vision] [--out DIR]: starts io_node and haptics_node on this machine, beside
// a bare echo, and reports the force round trip, its hops, its ratio to the bare echo of the same run and a verdict; with --hosts HUB it
// measures a system that runs already. hapton latency compare A B: two such reports side by side.
void add_latency_command(CommandLine app, int& exit_code);

}  // namespace hapton
