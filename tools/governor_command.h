#pragma once

#include "tools/command_line.h"

namespace hapton {

// Adds `hapton governor`: hostile programs against the safety governor of io_node. Exit code 0 only when nothing happened that must not.
void add_governor_command(CommandLine app, int& exit_code);

}  // namespace hapton
