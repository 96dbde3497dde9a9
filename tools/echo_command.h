#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton echo --bind ADDR:PORT [--seconds N] [--rt MODE]: returns every UDP datagram to its sender, at the least cost there is.
void add_echo_command(CLI::App& app, int& exit_code);

}  // namespace hapton
