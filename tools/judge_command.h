#pragma once

#include <CLI/CLI.hpp>

namespace hapton {

// hapton judge --mesh FILE --method proxy: a method's force error against the reference along a made trajectory.
void add_judge_command(CLI::App& app, int& exit_code);

}  // namespace hapton
