#pragma once

#include <optional>
#include <vector>

#include "vision_node/stereo_camera.h"

namespace hapton {

// The scene's surface as one eye sees it: its depth at each pixel. Nothing of the scene lies between eye and surface. Frame: W. Depth: the
// distance from the plane through the eye, along the viewing direction, m. Pixels: from the picture's lower left corner, centres at .5.
class VisibleDepth {
 public:
  // depths: OpenGL's, 0 to 1, by rows from the lower left corner; 1 where there is nothing.
  VisibleDepth(const StereoScreen& screen, Eye eye, PictureSize size, std::vector<float> depths);

  // Depth of the surface at that pixel; infinite for background, and outside the picture.
  double depth_m(const Vec2& pixel) const;
  // Point of the surface at that pixel; none for background, and outside the picture.
  std::optional<Vec3> find(const Vec2& pixel) const;

  Vec2 pixel_of(const Vec3& p_W) const { return project_to_pixel(screen_, eye_, size_, p_W); }
  double depth_of(const Vec3& p_W) const { return depths_of_eye_.eye_m - (screen_.X_WV.inverse(Eigen::Isometry) * p_W).z(); }
  // The depth of the near clipping plane: the eye sees nothing nearer.
  double near_m() const { return depths_of_eye_.near_m; }
  // The point with that depth which the eye sees at that pixel.
  Vec3 place(const Vec2& pixel, double depth_m) const;

  const StereoScreen& screen() const { return screen_; }
  PictureSize size() const { return size_; }

 private:
  StereoScreen screen_;
  Eye eye_;
  EyeDepths depths_of_eye_;
  PictureSize size_;
  std::vector<float> depths_;
};

}  // namespace hapton
