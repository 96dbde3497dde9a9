#pragma once

#include <optional>
#include <string>

#include "vision_node/stereo_camera.h"

namespace hapton {

// Where a probe that is out of the picture is to be found.
struct EdgePointer {
  Vec2 at_px = Vec2::Zero();    // just within the picture's edge, from its lower left corner
  Vec2 towards = Vec2::Zero();  // unit
  std::string label;            // how far it is from the middle of the picture
};

// None while the point is in the picture. Frame W. Whatever is not finite is nowhere.
std::optional<EdgePointer> find_edge_pointer(const StereoScreen& screen, Eye eye, PictureSize size, const Vec3& p_W);

}  // namespace hapton
