#pragma once

#include <string>

#include "core/base/result.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {

// Returns the names: "slide, free, tap, walk".
std::string trajectory_kinds();

// Makes a trajectory of a kind. Error: an unknown kind, or a mesh without area. RT: no.
Result<TouchTrajectory> make_trajectory(const std::string& kind, const TriangleMesh& mesh, const TrajectorySettings& settings);

}  // namespace hapton
