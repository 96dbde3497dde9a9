#pragma once

#include "core/math/types.h"
#include "devices/device.h"
#include "link/messages.h"

namespace hapton {

enum class SceneReach : std::uint8_t { unknown, in_reach, out_of_reach, too_small };

// Whether a device with these limits can touch the scene at its pose. Too small: the longest side of the scene's box is below a fiftieth of
// the workspace's. Out of reach: that box, made parallel to the axes of W, does not meet the workspace. In reach: one of the scene's points
// is in the workspace. Unknown: none of these, or no workspace or no points are given. RT: yes.
SceneReach find_reach(const SceneFacts& scene, const Pose& X_WS, const DeviceLimits& limits) noexcept;

// The scene's pose given by a view transform that the codec has accepted.
Pose pose_of(const ViewTransform& view) noexcept;

// Position of the scene's point i in W, m. Pre: i < scene.point_count. RT: yes.
Vec3 point_in_world(const SceneFacts& scene, const Pose& X_WS, std::size_t i) noexcept;

}  // namespace hapton
