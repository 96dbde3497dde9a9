#pragma once

#include "vision_node/stereo_camera.h"

namespace hapton {

// The rectangle in which one eye's image is shown in the window. Pixels from the lower left corner of the window.
struct MirrorPlace {
  int x_px = 0;  // lower left corner of the rectangle
  int y_px = 0;
  PictureSize size;

  // The pixel of the eye's image that is shown at a pixel of the window; beyond the image for pixels beside the rectangle. eye: size of the
  // image.
  Eigen::Vector2i to_eye(int window_x_px, int window_y_px, PictureSize eye) const;
};

// The largest rectangle with the aspect ratio of the image, centred in the window. Pre: both sizes are positive.
MirrorPlace place_mirror(PictureSize window, PictureSize eye);

}  // namespace hapton
