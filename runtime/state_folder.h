#pragma once

#include <filesystem>

namespace hapton {

// The folder for files that a program writes without being told where: $STATE_DIRECTORY (set by systemd), else $XDG_STATE_HOME/hapton, else
// ~/.local/state/hapton; empty if there is none. Not created here. RT: set-up only.
std::filesystem::path find_state_folder();

// The folder for files that outlive the process, but not the boot, the systemd unit or the user's last login session: $RUNTIME_DIRECTORY
// (set by systemd), else $XDG_RUNTIME_DIR/hapton; empty if there is none. Not created here. RT: set-up only.
std::filesystem::path find_runtime_folder();

}  // namespace hapton
