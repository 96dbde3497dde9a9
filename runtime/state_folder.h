#pragma once

#include <filesystem>

namespace hapton {

// Where a program keeps what it writes unasked: $STATE_DIRECTORY (as systemd sets it), else $XDG_STATE_HOME/hapton, else
// ~/.local/state/hapton; empty when there is none. Not made here. RT: set-up only.
std::filesystem::path find_state_folder();

// Where it keeps what is to outlive the process, and not the machine: $RUNTIME_DIRECTORY (as systemd sets it), else
// $XDG_RUNTIME_DIR/hapton; empty when there is none. Not made here. RT: set-up only.
std::filesystem::path find_runtime_folder();

}  // namespace hapton
