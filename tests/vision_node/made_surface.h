#pragma once

#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "vision_node/visible_depth.h"

namespace hapton {

// The depths that the eye in the middle sees. depth_m returns the depth of the surface at a pixel: infinity where there is no surface.
inline VisibleDepth make_visible_depth(const StereoScreen& screen, PictureSize size,
                                       const std::function<double(double x, double y)>& depth_m) {
  std::vector<float> depths;
  for (int y = 0; y < size.height_px; ++y) {
    for (int x = 0; x < size.width_px; ++x) {
      const double pixel_depth_m = depth_m(x + 0.5, y + 0.5);
      const double n = screen.near_m;
      const double f = screen.far_m;
      const double ndc = (f + n - 2.0 * f * n / pixel_depth_m) / (f - n);
      depths.push_back(std::isfinite(pixel_depth_m) ? static_cast<float>(0.5 * ndc + 0.5) : 1.0F);
    }
  }
  return {screen, Eye::centre, size, std::move(depths)};
}

}  // namespace hapton
