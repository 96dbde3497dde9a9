#pragma once

#include <string>

#include "core/base/result.h"
#include "core/geometry/touch_trajectory.h"
#include "tools/command_line.h"

namespace hapton {

// hapton trajectory --mesh FILE --kind slide|free|tap|walk --seed N --out T.csv: makes a trajectory for replay.
void add_trajectory_command(CommandLine app, int& exit_code);

// slide | free | tap | walk.
std::string trajectory_kinds();

// Error: unknown kind, a mesh without area.
Result<TouchTrajectory> make_trajectory(const std::string& kind, const TriangleMesh& mesh, const TrajectorySettings& settings);

}  // namespace hapton
