#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton bench objects: what a step costs for other objects being in the scene.
void add_bench_objects_command(CommandLine bench, int& exit_code);

}  // namespace hapton
