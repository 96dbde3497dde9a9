#pragma once

#include <optional>
#include <vector>

#include "vision_node/stereo_camera.h"

namespace hapton {

// The scene's surface as one eye sees it: how far away it is at each pixel. All in front of it is empty. Frames: W, and the eye's depth,
// the distance from the eye's plane along its viewing direction, m.
class VisibleDepth {
 public:
  // depths: OpenGL's, 0 to 1, by rows from the lower left corner; 1 where there is nothing.
  VisibleDepth(const StereoScreen& screen, Eye eye, PictureSize size, std::vector<float> depths);

  // Of the surface at that pixel; infinite for background, and outside the picture.
  double depth_m(const Vec2& pixel) const;
  // None for background.
  std::optional<Vec3> find(const Vec2& pixel) const;

  Vec2 pixel_of(const Vec3& p_W) const { return project_to_pixel(screen_, eye_, size_, p_W); }
  double depth_of(const Vec3& p_W) const { return depths_of_eye_.eye_m - (screen_.X_WV.inverse(Eigen::Isometry) * p_W).z(); }
  // The least that it can see.
  double near_m() const { return depths_of_eye_.near_m; }
  // The point at that depth that is seen at that pixel.
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
