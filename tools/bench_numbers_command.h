#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton bench numbers, and hapton bench alone: the numbers to beat, target and ours side by side, in one run.
void add_bench_numbers_command(CommandLine bench, int& exit_code);

}  // namespace hapton
