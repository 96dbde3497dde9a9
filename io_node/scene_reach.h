#pragma once

#include "core/math/types.h"
#include "devices/device.h"
#include "link/messages.h"

namespace hapton {

enum class SceneReach : std::uint8_t { unknown, in_reach, out_of_reach, too_small };

// Whether a device with these limits can touch the scene at its pose. Out of reach: its box and the workspace do not
// intersect. In reach: one of its points is inside. Too small: its longest side is below a fiftieth of the workspace's. RT:
// yes.
SceneReach find_reach(const SceneFacts& scene, const Pose& X_WS, const DeviceLimits& limits) noexcept;

// The scene's pose given by a view transform that the codec has accepted.
Pose pose_of(const ViewTransform& view) noexcept;

// A point of it in W. Pre: i below its count. RT: yes.
Vec3 point_in_world(const SceneFacts& scene, const Pose& X_WS, std::size_t i) noexcept;

}  // namespace hapton
