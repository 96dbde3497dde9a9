#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton info FILE: counts, size and flaws of a mesh, or the objects of a scene.
// Sets exit_code to 0 when all could be told, 1 otherwise.
void add_info_command(CLI::App& app, int& exit_code);

}  // namespace hapton
