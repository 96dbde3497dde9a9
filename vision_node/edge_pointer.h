#pragma once

#include <optional>
#include <string>

#include "vision_node/stereo_camera.h"

namespace hapton {

// A mark at the picture's edge that points to a probe outside the picture.
struct EdgePointer {
  Vec2 at_px = Vec2::Zero();    // just inside the picture's edge, from its lower left corner
  Vec2 towards = Vec2::Zero();  // direction to the probe in the picture, of unit length
  std::string label;            // with the distance of the probe from the screen's centre
};

// None: the point is in the picture or not finite, or the picture has no size. Frame W.
std::optional<EdgePointer> find_edge_pointer(const StereoScreen& screen, Eye eye, PictureSize size, const Vec3& p_W);

}  // namespace hapton
