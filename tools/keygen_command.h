#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton keygen: a new key file for nodes on several machines.
void add_keygen_command(CLI::App& app, int& exit_code);

}  // namespace hapton
