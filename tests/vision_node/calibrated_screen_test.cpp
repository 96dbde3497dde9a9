// A screen in any pose, as the cameras use it: a point is drawn where the straight line from the eye to the point crosses the screen.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "scene/scene_file.h"
#include "vision_node/camera_view.h"
#include "vision_node/scene_framing.h"
#include "vision_node/stereo_camera.h"

namespace hapton {
namespace {

constexpr PictureSize kStretched{640, 300};  // pixels that are not square

struct PlacedScreen {
  std::string name;
  ScreenRectangle screen;
  Head head;
};

std::vector<PlacedScreen> placed_screens() {
  const auto about = [](double degrees, const Vec3& axis) { return Quat(Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis)); };
  const auto at = [](const Vec3& p_W, const Quat& q, double width_m, double height_m) {
    return ScreenRectangle{Eigen::Translation3d(p_W) * q, width_m, height_m};
  };
  return {{"upright, head before its middle", at({0.0, 0.0, 0.0}, Quat::Identity(), 0.24, 0.15), {}},
          {"leans back, head aside", at({0.03, 0.05, -0.12}, about(-35.0, Vec3::UnitX()), 0.24, 0.15), {{-0.2, 0.1, 0.45}}},
          {"a table, head turned",
           at({0.0, -0.1, 0.02}, about(-90.0, Vec3::UnitX()), 0.3, 0.3),
           {{0.1, -0.25, 0.5}, about(40.0, Vec3::UnitY())}},
          {"at the side and rolled",
           at({0.1, 0.0, -0.1}, about(-40.0, Vec3::UnitY()) * about(8.0, Vec3::UnitZ()), 0.5, 0.28),
           {{0.3, -0.05, 0.7}, about(20.0, Vec3::UnitZ())}},
          {"a wall far behind", at({0.0, 0.5, -1.5}, Quat::Identity(), 2.0, 1.5), {{0.2, 0.1, 2.1}}}};
}

Framing framing_of(const PlacedScreen& placed) {
  VisionOptions options;
  options.screen = placed.screen;
  options.head = placed.head;
  return frame_scene(Scene(), options);
}

// From the corners alone: the pixel at which the line from the eye to the point crosses the plane of the screen.
Vec2 pixel_by_corners(const PlacedScreen& placed, Eye eye, PictureSize size, const Vec3& p_W) {
  const ScreenCorners corners = find_corners(placed.screen);
  const Vec3 right = corners[1] - corners[0];
  const Vec3 up = corners[3] - corners[0];
  const Vec3 normal = right.cross(up).normalized();
  const double side = eye == Eye::left ? -0.5 : eye == Eye::right ? 0.5 : 0.0;
  const Vec3 p_RE = placed.head.p_RH + 0.063 * side * (placed.head.q_RH * Vec3::UnitX());
  const Vec3 p_WE = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]) + p_RE.x() * right.normalized() +
                    p_RE.y() * up.normalized() + p_RE.z() * normal;
  const double share = normal.dot(corners[0] - p_WE) / normal.dot(p_W - p_WE);
  const Vec3 hit = p_WE + share * (p_W - p_WE) - corners[0];
  return {hit.dot(right) / right.squaredNorm() * size.width_px, hit.dot(up) / up.squaredNorm() * size.height_px};
}

Vec2 pixel_by_camera(const StereoScreen& screen, Eye eye, PictureSize size, const Vec3& p_W) {
  const Eigen::Vector4d clip = compute_projection_matrix(screen, eye) * compute_view_matrix(screen, eye) * p_W.homogeneous();
  return {(clip.x() / clip.w() + 1.0) * 0.5 * size.width_px, (clip.y() / clip.w() + 1.0) * 0.5 * size.height_px};
}

TEST(CalibratedScreen, APointIsDrawnOnTheLineFromTheEyeToIt) {
  constexpr std::uint64_t kSeed = 11;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.1, 0.1);
  for (const PlacedScreen& placed : placed_screens()) {
    const StereoScreen screen = compute_screen(framing_of(placed), kStretched);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p_W(coordinate(random), coordinate(random), coordinate(random));
      for (const Eye eye : {Eye::left, Eye::right, Eye::centre}) {
        const Vec2 expected = pixel_by_corners(placed, eye, kStretched, p_W);
        EXPECT_LT((pixel_by_camera(screen, eye, kStretched, p_W) - expected).norm(), 1e-8) << placed.name << ", seed " << kSeed;
        EXPECT_LT((project_to_pixel(screen, eye, kStretched, p_W) - expected).norm(), 1e-8) << placed.name;
      }
    }
  }
}

// For every head and every window, a point of the screen is drawn at its own place: a millimetre is drawn as a millimetre there.
TEST(CalibratedScreen, PointsOfTheScreenAreDrawnWhereTheyAre) {
  for (const PlacedScreen& placed : placed_screens()) {
    for (const PictureSize size : {PictureSize{640, 480}, kStretched, PictureSize{300, 900}}) {
      const StereoScreen screen = compute_screen(framing_of(placed), size);
      EXPECT_EQ(screen.width_m, placed.screen.width_m);
      EXPECT_EQ(screen.height_m, placed.screen.height_m);
      const ScreenCorners corners = find_corners(placed.screen);
      for (const Eye eye : {Eye::left, Eye::right}) {
        EXPECT_LT((pixel_by_camera(screen, eye, size, corners[0]) - Vec2(0, 0)).norm(), 1e-9) << placed.name;
        EXPECT_LT((pixel_by_camera(screen, eye, size, corners[2]) - Vec2(size.width_px, size.height_px)).norm(), 1e-9) << placed.name;
      }
    }
  }
}

TEST(CalibratedScreen, TheViewerIsAsLargeAsInReality) {
  for (const PlacedScreen& placed : placed_screens()) {
    const Framing framing = framing_of(placed);
    const StereoScreen screen = compute_screen(framing, kStretched);
    EXPECT_EQ(screen.ipd_m, 0.063);
    EXPECT_NEAR(screen.distance_m, placed.head.p_RH.z(), 1e-15);
    EXPECT_EQ(compute_viewer_scale(framing, screen.width_m), 1.0);
    const Vec3 p_WE = compute_eye_position(screen, Eye::centre);
    EXPECT_LT((p_WE - placed.screen.X_WR * placed.head.p_RH).norm(), 1e-15) << placed.name;
  }
}

// The scene and the workspace lie between the near and the far plane, except for parts that are not in front of the eyes.
TEST(CalibratedScreen, TheWorkspaceIsBetweenNearAndFar) {
  // Half of the diagonal of the workspace.
  const double radius_m = 0.5 * Vec3(0.2667, 0.1905, 0.381).norm();
  for (const PlacedScreen& placed : placed_screens()) {
    const StereoScreen screen = compute_screen(framing_of(placed), kStretched);
    const double ahead_m = screen.distance_m - (placed.screen.X_WR.inverse() * Vec3(Vec3::Zero())).z();
    EXPECT_LT(screen.near_m, std::max(ahead_m - radius_m, 0.051 * screen.distance_m)) << placed.name;
    EXPECT_GT(screen.near_m, 0.0);
    EXPECT_GT(screen.far_m, ahead_m + radius_m) << placed.name;
    EXPECT_GT(screen.far_m, screen.distance_m) << placed.name << ": haze begins at the screen";
  }
}

TEST(CalibratedScreen, NeitherOrbitNorZoomNorPanMovesThePicture) {
  for (const PlacedScreen& placed : placed_screens()) {
    const Framing home = framing_of(placed);
    CameraView view;
    view.orbit(0.3, 0.2);
    view.zoom_by(2.0);
    view.pan_m = Vec3(0.1, 0.0, 0.0);
    view.look_at(home, Vec3(0.02, 0.0, 0.0), 0.05);
    const StereoScreen unmoved = compute_screen(home, kStretched);
    const StereoScreen moved = compute_screen(view.apply(home), kStretched);
    EXPECT_EQ(moved.X_WV.matrix(), unmoved.X_WV.matrix());
    EXPECT_EQ(moved.width_m, unmoved.width_m);
    EXPECT_EQ(moved.ipd_m, unmoved.ipd_m);
    EXPECT_EQ(moved.near_m, unmoved.near_m);
  }
}

}  // namespace
}  // namespace hapton
