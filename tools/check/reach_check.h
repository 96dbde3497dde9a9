#pragma once

#include "closed_loop/device_model.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// The region that the device point can reach: a box, or a ball in the middle of the box. Frame W.
struct Workspace {
  Vec3 low_m;
  Vec3 high_m;
  double radius_m = 0.0;  // radius of the ball; 0: the whole box

  Vec3 middle_m() const { return 0.5 * (low_m + high_m); }
  double longest_m() const { return (high_m - low_m).maxCoeff(); }
  // The distance of p from the nearest point of the workspace; 0 inside.
  double distance_m(const Vec3& p) const;
};
// Pre: device.is_workspace_known.
Workspace workspace_of(const DevicePreset& device);

// The part of a mesh that lies outside the workspace.
struct Unreached {
  double share = 0.0;            // this part of the mesh's area, 0 to 1
  Vec3 farthest = Vec3::Zero();  // the vertex farthest outside; meaningless where the share is 0
  double distance_m = 0.0;       // how far that vertex is outside
};
// Exact up to rounding for a box, at whose faces triangles are cut. Triangles that cross a ball are split until no corner is farther than a
// 200th of its radius from their middle; then the middle decides. For a mesh without area, `share` counts vertices. RT: set-up only.
Unreached find_unreached(const TriangleMesh& mesh, const Workspace& workspace);

// Finds whether a thousandth or more of the object's surface is outside the device's workspace at rest or, if not, at the keyframe farthest
// outside. The knob box is at zero, so S equals W. RT: set-up only.
// Pre: device.is_workspace_known, here and below.
CheckFindings check_reach(const SceneObject& object, const DevicePreset& device);
// Finds an effect whose volume is outside the workspace; a gravity well so far outside that the friction of the device hides it; a magnet
// (point, line or plane to snap to) whose range ends before the workspace. For a line or plane the workspace is taken as the ball around
// it, so that one which passes a box near its corners is not found. RT: set-up only.
CheckFindings check_reach(const SceneEffect& effect, const DevicePreset& device);

// Finds whether the scene's longest side is below 2 % of the workspace's, as SceneReach::too_small does. RT: set-up only.
CheckFindings check_size(const Scene& scene, const DevicePreset& device);

}  // namespace hapton
