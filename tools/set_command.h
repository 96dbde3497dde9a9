#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton set --hub HOST:PORT: changes a running system: servo rate, force method, or a report now.
void add_set_command(CLI::App& app, int& exit_code);

}  // namespace hapton
