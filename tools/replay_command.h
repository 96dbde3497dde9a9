#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton replay: drives the haptic step of the live node along a recorded trajectory and writes what it felt, step by step.
void add_replay_command(CommandLine app, int& exit_code);

}  // namespace hapton
