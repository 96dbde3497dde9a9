#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton bench haptons: how many triangle pairs a millisecond one core collides on edge, located to 0.1 % (memo 3.0). Exit code 0 only when
// that accuracy held for every pair.
void add_bench_haptons_command(CommandLine bench, int& exit_code);

}  // namespace hapton
