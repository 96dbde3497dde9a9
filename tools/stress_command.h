#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton stress --method proxy --steps N --seed S: numerical torture; exit code 0 only when nothing went wrong.
void add_stress_command(CommandLine app, int& exit_code);

}  // namespace hapton
