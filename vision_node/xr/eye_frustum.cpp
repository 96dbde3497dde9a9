#include "vision_node/xr/eye_frustum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hapton {
namespace {

// Distance of the near plane: so short that a stylus directly in front of the eyes is still drawn.
constexpr double kNearestM = 0.02;
// The least distance of the image plane: well beyond the near plane, also when the head is in the workspace.
constexpr double kNearestPlaneM = 0.1;

}  // namespace

bool is_possible(const FieldOfView& fov) {
  constexpr double kRight = 0.5 * std::numbers::pi;
  return -kRight < fov.left_rad && fov.left_rad < fov.right_rad && fov.right_rad < kRight && -kRight < fov.down_rad &&
         fov.down_rad < fov.up_rad && fov.up_rad < kRight;
}

HeadsetDepths find_headset_depths(const Framing& framing, const Vec3& p_WE) {
  const double distance_m = (framing.p_WC - p_WE).norm();
  HeadsetDepths depths;
  depths.plane_m = std::max(kNearestPlaneM, distance_m);
  depths.near_m = kNearestM;
  depths.far_m = depths.plane_m + framing.depth_m;
  return depths;
}

StereoScreen look_through(const EyeInFrame& eye_in_W, const HeadsetDepths& depths, const Vec3& light_W) {
  const double left = std::tan(eye_in_W.fov.left_rad);
  const double right = std::tan(eye_in_W.fov.right_rad);
  const double up = std::tan(eye_in_W.fov.up_rad);
  const double down = std::tan(eye_in_W.fov.down_rad);
  const Vec2 middle = 0.5 * depths.plane_m * Vec2(left + right, up + down);
  StereoScreen screen;
  screen.X_WV = eye_in_W.X_FE * Eigen::Translation3d(middle.x(), middle.y(), -depths.plane_m);
  screen.width_m = depths.plane_m * (right - left);
  screen.height_m = depths.plane_m * (up - down);
  screen.distance_m = depths.plane_m;
  screen.eyes_offset_m = -middle;
  screen.ipd_m = 0.0;
  screen.near_m = depths.near_m;
  screen.far_m = depths.far_m;
  screen.light_V = screen.X_WV.linear().transpose() * light_W;
  return screen;
}

}  // namespace hapton
