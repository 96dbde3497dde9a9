#pragma once

#include "closed_loop/device_model.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// What the device point reaches: a box, or the ball in its middle. Frame W.
struct Workspace {
  Vec3 low_m;
  Vec3 high_m;
  double radius_m = 0.0;  // of the ball; 0: the whole box

  Vec3 middle_m() const { return 0.5 * (low_m + high_m); }
  double longest_m() const { return (high_m - low_m).maxCoeff(); }
  // From the nearest point of it; 0 inside.
  double distance_m(const Vec3& p) const;
};
// Pre: device.is_workspace_known.
Workspace workspace_of(const DevicePreset& device);

// Which part of a mesh lies outside.
struct Unreached {
  double share = 0.0;            // of its area, 0 to 1
  Vec3 farthest = Vec3::Zero();  // the vertex farthest outside; meaningless where the share is 0
  double distance_m = 0.0;       // of it
};
// Exact up to rounding for a box, at which triangles are cut. Triangles that cross a ball are split until no corner is farther than a
// 200th of its radius from their middle; then the middle decides. A mesh without area counts by its vertices. RT: set-up only.
Unreached find_unreached(const TriangleMesh& mesh, const Workspace& workspace);

// Finds whether a part of the object lies outside the device's workspace, at rest or else at the keyframe that goes farthest out. S lies on
// W: the knob box is at zero. RT: set-up only.
// Pre: device.is_workspace_known, here and below.
CheckFindings check_reach(const SceneObject& object, const DevicePreset& device);
// An effect in a volume outside the workspace; a gravity well so far outside that the friction of the device hides it; a magnet, or a line
// or plane to snap to, whose range ends before the workspace. A line or plane counts as reached if it comes as near as the farthest point
// of the workspace lies from its middle. RT: set-up only.
CheckFindings check_reach(const SceneEffect& effect, const DevicePreset& device);

// Finds whether the whole scene is too small for the workspace: below the same share as SceneReach::too_small. RT: set-up only.
CheckFindings check_size(const Scene& scene, const DevicePreset& device);

}  // namespace hapton
