#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton keygen: a new key file for nodes on several machines.
void add_keygen_command(CommandLine app, int& exit_code);

}  // namespace hapton
