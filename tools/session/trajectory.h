#pragma once

#include <string>

#include "core/base/result.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {

// slide | free | tap | walk.
std::string trajectory_kinds();

// Error: unknown kind, a mesh without area. RT: no.
Result<TouchTrajectory> make_trajectory(const std::string& kind, const TriangleMesh& mesh, const TrajectorySettings& settings);

}  // namespace hapton
