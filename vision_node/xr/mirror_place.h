#pragma once

#include "vision_node/stereo_camera.h"

namespace hapton {

// Where one eye's image is in the window: as large as fits, in the middle, not distorted. Pixels from the lower left corner.
struct MirrorPlace {
  int x_px = 0;
  int y_px = 0;
  PictureSize size;

  // The pixel of the eye's image that is shown at that pixel of the window; outside of the image where it is outside.
  Eigen::Vector2i to_eye(int window_x_px, int window_y_px, PictureSize eye) const;
};

// Pre: both sizes are positive.
MirrorPlace place_mirror(PictureSize window, PictureSize eye);

}  // namespace hapton
