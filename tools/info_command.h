#pragma once

#include "tools/command_line.h"

namespace hapton {

// hapton info FILE: counts, size and flaws of a mesh, or the objects of a scene.
// Sets exit_code to 0 when all could be told, 1 otherwise.
void add_info_command(CommandLine app, int& exit_code);

}  // namespace hapton
