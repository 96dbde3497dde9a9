#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// `hapton doctor`: what is wrong with this machine for haptics, and the line that mends it.
// Exit code: 0 no problem, 1 problems, 2 a command line that makes no sense.
void add_doctor_command(CLI::App& app, int& exit_code);

}  // namespace hapton
