#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton bench: the parent of all measurements; each child has a file of its own, tools/bench_<name>_command.
void add_bench_command(CommandLine app, int& exit_code);

}  // namespace hapton
