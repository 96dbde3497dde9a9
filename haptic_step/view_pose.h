#pragma once

#include <array>
#include <optional>

#include "core/math/types.h"

namespace hapton {

// The pose that the 12 numbers of a view transform mean (row-major 3 x 4, [R|t]), or none when they are no rotation and
// translation: not finite, scaled, sheared or mirrored by more than single precision rounds. The rotation is the nearest exact one.
// RT: yes.
std::optional<Pose> compute_view_pose(const std::array<float, 12>& X_WS) noexcept;

}  // namespace hapton
