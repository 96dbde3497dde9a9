#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton judge --mesh FILE --method proxy: a method's force error against the reference along a made trajectory.
void add_judge_command(CommandLine app, int& exit_code);

}  // namespace hapton
