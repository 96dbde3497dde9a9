#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton set --hub HOST:PORT: changes a running system: servo rate, force method, or a report now.
void add_set_command(CommandLine app, int& exit_code);

}  // namespace hapton
