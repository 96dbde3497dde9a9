#pragma once

#include "tools/command_line.h"

namespace hapton {

// Adds `hapton soak`. exit_code is set when it has run: 0 flat, 1 not.
void add_soak_command(CommandLine app, int& exit_code);

}  // namespace hapton
