#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton replay: drives the haptic step of the live node along a recorded trajectory and writes what it felt, step by step.
void add_replay_command(CLI::App& app, int& exit_code);

}  // namespace hapton
