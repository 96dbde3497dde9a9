#pragma once

namespace hapton {

// The `hapton` program: reads the command line and runs the command it names. Gives the exit code: 0 only when the thing asked for
// held, 2 after a command line that is not understood.
// RT: set-up only.
int run_hapton_command(int argc, const char* const* argv);

}  // namespace hapton
