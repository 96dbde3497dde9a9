#pragma once

#include <optional>
#include <string>

#include "vision_node/stereo_camera.h"

namespace hapton {

// Where a probe outside the picture is.
struct EdgePointer {
  Vec2 at_px = Vec2::Zero();    // just inside the picture's edge, from its lower left corner
  Vec2 towards = Vec2::Zero();  // unit
  std::string label;            // its distance from the middle of the picture
};

// Empty while the point is in the picture. Frame W. Empty also for points that are not finite.
std::optional<EdgePointer> find_edge_pointer(const StereoScreen& screen, Eye eye, PictureSize size, const Vec3& p_W);

}  // namespace hapton
