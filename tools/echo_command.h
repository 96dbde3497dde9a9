#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton echo --bind ADDR:PORT [--seconds N] [--rt MODE]: returns every UDP datagram to its sender, at the least cost there is.
void add_echo_command(CommandLine app, int& exit_code);

}  // namespace hapton
