#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// Adds "session info|export|replay" to the command line; exit_code is set when one runs.
void add_session_command(CLI::App& app, int& exit_code);

}  // namespace hapton
