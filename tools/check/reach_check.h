#pragma once

#include "devices/device.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// Which part of a mesh lies outside a box.
struct Unreached {
  double share = 0.0;            // of its area, 0 to 1
  Vec3 farthest = Vec3::Zero();  // the vertex farthest outside; meaningless where the share is 0
  double distance_m = 0.0;       // of it
};
// Exact up to rounding: triangles are cut at the box. A mesh without area counts by its vertices. RT: set-up only.
Unreached find_unreached(const TriangleMesh& mesh, const Vec3& low, const Vec3& high);

// Finds whether a part of the object lies outside the device's workspace. S lies on W: the knob box is at zero. RT: set-up only.
CheckFindings check_reach(const SceneObject& object, const DeviceLimits& limits);

// Finds whether the whole scene is too small for the workspace: below the same share as SceneReach::too_small. RT: set-up only.
CheckFindings check_size(const Scene& scene, const DeviceLimits& limits);

}  // namespace hapton
