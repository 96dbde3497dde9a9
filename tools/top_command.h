#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton top [--hub HOST:PORT] [--once] [--interval S]: a running system's nodes, rates, latencies and counters, in the terminal.
void add_top_command(CommandLine app, int& exit_code);

}  // namespace hapton
