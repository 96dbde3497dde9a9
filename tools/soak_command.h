#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// Adds `hapton soak`. exit_code is set when it has run: 0 flat, 1 not.
void add_soak_command(CLI::App& app, int& exit_code);

}  // namespace hapton
