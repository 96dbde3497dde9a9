#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "core/base/result.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {

// hapton trajectory --mesh FILE --kind slide|free|tap|walk --seed N --out T.csv: makes a trajectory for replay.
void add_trajectory_command(CLI::App& app, int& exit_code);

// slide | free | tap | walk.
std::string trajectory_kinds();

// Error: unknown kind, a mesh without area.
Result<TouchTrajectory> make_trajectory(const std::string& kind, const TriangleMesh& mesh, const TrajectorySettings& settings);

}  // namespace hapton
