#include "vision_node/visible_depth.h"

#include <cmath>
#include <limits>
#include <utility>

namespace hapton {

VisibleDepth::VisibleDepth(const StereoScreen& screen, Eye eye, PictureSize size, std::vector<float> depths)
    : screen_(screen), eye_(eye), depths_of_eye_(compute_eye_depths(screen, eye)), size_(size), depths_(std::move(depths)) {}

double VisibleDepth::depth_m(const Vec2& pixel) const {
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  if (!(pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() < size_.width_px && pixel.y() < size_.height_px)) return kNothing;
  const auto at = static_cast<std::size_t>(pixel.y()) * static_cast<std::size_t>(size_.width_px) + static_cast<std::size_t>(pixel.x());
  if (at >= depths_.size() || !(depths_[at] < 1.0F)) return kNothing;
  const double ndc = 2.0 * static_cast<double>(depths_[at]) - 1.0;
  const double n = depths_of_eye_.near_m;
  const double f = depths_of_eye_.far_m;
  return 2.0 * f * n / (f + n - ndc * (f - n));
}

std::optional<Vec3> VisibleDepth::find(const Vec2& pixel) const {
  const double depth = depth_m(pixel);
  return std::isfinite(depth) ? std::optional(place(pixel, depth)) : std::nullopt;
}

Vec3 VisibleDepth::place(const Vec2& pixel, double depth_m) const {
  const Vec3 p_VE = screen_.X_WV.inverse(Eigen::Isometry) * compute_eye_position(screen_, eye_);
  const Vec3 on_screen_V((pixel.x() / size_.width_px - 0.5) * screen_.width_m, (pixel.y() / size_.height_px - 0.5) * screen_.height_m, 0.0);
  return screen_.X_WV * Vec3(p_VE + depth_m / depths_of_eye_.eye_m * (on_screen_V - p_VE));
}

}  // namespace hapton
