#pragma once

#include "tools/command_line.h"

namespace hapton {

// `hapton doctor`: what is wrong with this machine for haptics, and the line that mends it.
// Exit code: 0 no problem, 1 problems, 2 a command line that makes no sense.
void add_doctor_command(CommandLine app, int& exit_code);

}  // namespace hapton
