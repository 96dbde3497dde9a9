#pragma once

namespace hapton {

// The `hapton` program: parses the command line and runs the command. Returns the exit code: 0 only if the command succeeded or only help
// or version was requested, 2 after an invalid command line, otherwise as in tools/commands.h. RT: set-up only.
int run_hapton_command(int argc, const char* const* argv);

}  // namespace hapton
