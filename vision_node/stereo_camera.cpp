#include "vision_node/stereo_camera.h"

#include <algorithm>

namespace hapton {
namespace {

// The largest sphere that is comfortable to view from arm's length.
constexpr double kDeskRadius = 0.2;
// A smaller sphere is viewed from a proportionally shorter distance: from kDeskDistance, its pixels would be smaller than the resolution
// of single precision.
constexpr double kSmallRadius = 0.002;
// A small margin round the framed object.
constexpr double kMargin = 1.06;

Vec3 eye_in_view(const StereoScreen& screen, Eye eye) {
  const double side = eye == Eye::left ? -0.5 : eye == Eye::right ? 0.5 : 0.0;
  return Vec3(screen.eyes_offset_m.x(), screen.eyes_offset_m.y(), screen.distance_m) + side * screen.ipd_m * screen.to_right_V;
}

// The smallest depth that is drawn, as a share of the distance to the screen. With a smaller one, the depth buffer would be too coarse.
constexpr double kNearShare = 0.05;

void place_picture(const Framing& framing, PictureSize size, StereoScreen& screen) {
  if (framing.screen) {
    screen.X_WV = framing.screen->X_WR;
    screen.width_m = framing.screen->width_m;
    screen.height_m = framing.screen->height_m;
    return;
  }
  const Eigen::AngleAxisd yaw(framing.yaw_rad, Vec3::UnitY());
  const Eigen::AngleAxisd pitch(-framing.pitch_rad, Vec3::UnitX());
  screen.X_WV = Eigen::Translation3d(framing.p_WC) * yaw * pitch *
                Eigen::Translation3d(framing.centre_offset_m.x(), framing.centre_offset_m.y(), 0.0);
  if (framing.roll_rad != 0.0) screen.X_WV.rotate(Eigen::AngleAxisd(framing.roll_rad, Vec3::UnitZ()));
  const double width = std::max(1, size.width_px);
  const double height = std::max(1, size.height_px);
  const double metres_per_pixel = framing.view_m / std::min(width, height);
  screen.width_m = width * metres_per_pixel;
  screen.height_m = height * metres_per_pixel;
}

void place_eyes(const Framing& framing, StereoScreen& screen) {
  const double scale = compute_viewer_scale(framing, screen.width_m);
  const double grown = scale * kDeskDistance / framing.distance_m;  // exactly 1 if the screen's width is not known, or if its place is
  const Vec3 from_desk = framing.head.p_RH - Head().p_RH;
  screen.distance_m = grown * framing.distance_m + scale * from_desk.z();
  screen.eyes_offset_m = scale * from_desk.head<2>();
  screen.to_right_V = framing.head.q_RH * Vec3::UnitX();
  screen.ipd_m = grown * framing.ipd_m;
}

}  // namespace

double compute_viewer_scale(const Framing& framing, double width_m) {
  if (framing.screen) return 1.0;
  return framing.screen_width_m > 0.0 ? width_m / framing.screen_width_m : framing.distance_m / kDeskDistance;
}

bool is_possible(const Head& head, double ipd_m) {
  const double height_m = head.p_RH.z() - 0.5 * ipd_m * std::abs((head.q_RH * Vec3::UnitX()).z());
  return height_m >= kNearestEyeM && head.p_RH.norm() <= kFarthestHeadM;  // false for NaN
}

Framing frame_sphere(const Vec3& p_WC, double radius_m, double ipd_m) {
  const double scale = radius_m < kSmallRadius ? radius_m / kSmallRadius : std::max(1.0, radius_m / kDeskRadius);
  Framing framing;
  framing.p_WC = p_WC;
  framing.distance_m = kDeskDistance * scale;
  framing.ipd_m = ipd_m * scale;
  // The cone that touches the sphere cuts the screen plane in a circle of radius d r / sqrt(d^2 - r^2).
  const double d = framing.distance_m;
  framing.view_m = 2.0 * kMargin * d * radius_m / std::sqrt(d * d - radius_m * radius_m);
  framing.depth_m = 2.0 * std::max(radius_m, kDeskRadius * scale);
  return framing;
}

StereoScreen compute_screen(const Framing& framing, PictureSize size) {
  StereoScreen screen;
  place_picture(framing, size, screen);
  place_eyes(framing, screen);
  // What is drawn lies around p_WC: in the screen's plane, or, if the framing gives the screen's place, in front of it or behind it.
  const double centre_z_m = framing.screen ? (framing.screen->X_WR.inverse(Eigen::Isometry) * framing.p_WC).z() : 0.0;
  screen.near_m = std::max(kNearShare * screen.distance_m, screen.distance_m - std::max(0.0, centre_z_m) - framing.depth_m);
  screen.far_m = screen.distance_m - std::min(0.0, centre_z_m) + framing.depth_m;
  return screen;
}

Vec3 compute_eye_position(const StereoScreen& screen, Eye eye) { return screen.X_WV * eye_in_view(screen, eye); }

EyeDepths compute_eye_depths(const StereoScreen& screen, Eye eye) {
  const double eye_m = eye_in_view(screen, eye).z();
  const double nearer_m = screen.distance_m - eye_m;
  return {eye_m, std::max(kNearShare * eye_m, screen.near_m - nearer_m), screen.far_m - nearer_m};
}

Mat4 compute_view_matrix(const StereoScreen& screen, Eye eye) {
  const Pose X_VE(Eigen::Translation3d(eye_in_view(screen, eye)));
  return (screen.X_WV * X_VE).inverse(Eigen::Isometry).matrix();
}

// A point (x, y, -d) of the screen plane must land on x / (w/2), y / (h/2) when x, y are measured from the screen's centre. Seen
// from the eye, that centre lies at (c_x, c_y) = (-e_x, -e_y). With perspective division by -z:
//   x_ndc = (2 d / w) (x / -z) - 2 c_x / w, and alike for y. Depth is OpenGL's, -1 at near, 1 at far.
Mat4 compute_projection_matrix(const StereoScreen& screen, Eye eye) {
  const Vec3 e = eye_in_view(screen, eye);
  const auto [d, n, f] = compute_eye_depths(screen, eye);
  Mat4 P = Mat4::Zero();
  P(0, 0) = 2.0 * d / screen.width_m;
  P(0, 2) = -2.0 * e.x() / screen.width_m;
  P(1, 1) = 2.0 * d / screen.height_m;
  P(1, 2) = -2.0 * e.y() / screen.height_m;
  P(2, 2) = -(f + n) / (f - n);
  P(2, 3) = -2.0 * f * n / (f - n);
  P(3, 2) = -1.0;
  return P;
}

Vec2 project_to_pixel(const StereoScreen& screen, Eye eye, PictureSize size, const Vec3& p_W) {
  const Vec3 p_V = screen.X_WV.inverse(Eigen::Isometry) * p_W;
  const Vec3 e = eye_in_view(screen, eye);
  const double stretch = e.z() / (e.z() - p_V.z());
  const double x = e.x() + (p_V.x() - e.x()) * stretch;
  const double y = e.y() + (p_V.y() - e.y()) * stretch;
  return {(x / screen.width_m + 0.5) * size.width_px, (y / screen.height_m + 0.5) * size.height_px};
}

double compute_disparity_m(const StereoScreen& screen, double z_m) { return screen.ipd_m * z_m / (z_m - screen.distance_m); }

Vec3 displace_in_screen_plane(const StereoScreen& screen, PictureSize size, const Vec2& pixels, double z_m) {
  const double shrink = (screen.distance_m - z_m) / screen.distance_m;
  const Vec3 d_V(pixels.x() * screen.width_m / size.width_px * shrink, pixels.y() * screen.height_m / size.height_px * shrink, 0.0);
  return screen.X_WV.linear() * d_V;
}

}  // namespace hapton
