#include "vision_node/xr/mirror_place.h"

#include <algorithm>
#include <cmath>

namespace hapton {

Eigen::Vector2i MirrorPlace::to_eye(int window_x_px, int window_y_px, PictureSize eye) const {
  const double x = (window_x_px + 0.5 - x_px) * eye.width_px / std::max(1, size.width_px);
  const double y = (window_y_px + 0.5 - y_px) * eye.height_px / std::max(1, size.height_px);
  return {static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y))};
}

MirrorPlace place_mirror(PictureSize window, PictureSize eye) {
  const double shrink =
      std::min(static_cast<double>(window.width_px) / eye.width_px, static_cast<double>(window.height_px) / eye.height_px);
  MirrorPlace place;
  place.size.width_px = std::max(1, static_cast<int>(std::lround(shrink * eye.width_px)));
  place.size.height_px = std::max(1, static_cast<int>(std::lround(shrink * eye.height_px)));
  place.x_px = (window.width_px - place.size.width_px) / 2;
  place.y_px = (window.height_px - place.size.height_px) / 2;
  return place;
}

}  // namespace hapton
