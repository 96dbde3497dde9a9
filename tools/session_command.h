#pragma once

#include "tools/command_line.h"

namespace hapton {

// Adds "session info|export|replay" to the command line; exit_code is set when one runs.
void add_session_command(CommandLine app, int& exit_code);

}  // namespace hapton
