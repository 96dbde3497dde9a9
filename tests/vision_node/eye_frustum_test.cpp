#include "vision_node/xr/eye_frustum.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/vision_node/xr/mock_views.h"

namespace hapton {
namespace {

const HeadsetDepths kDepths{.plane_m = 0.7, .near_m = 0.05, .far_m = 2.5};
const Vec3 kLight = Vec3(0.2, 0.9, 0.3).normalized();

// By OpenXR's definition: at distance 1, the edges of the picture are at the tangents of the angles.
Mat4 frustum_of(const FieldOfView& fov, double near_m, double far_m) {
  const double l = std::tan(fov.left_rad), r = std::tan(fov.right_rad), u = std::tan(fov.up_rad), d = std::tan(fov.down_rad);
  Mat4 P = Mat4::Zero();
  P.row(0) << 2.0 / (r - l), 0.0, (r + l) / (r - l), 0.0;
  P.row(1) << 0.0, 2.0 / (u - d), (u + d) / (u - d), 0.0;
  P.row(2) << 0.0, 0.0, -(far_m + near_m) / (far_m - near_m), -2.0 * far_m * near_m / (far_m - near_m);
  P.row(3) << 0.0, 0.0, -1.0, 0.0;
  return P;
}

TEST(EyeFrustum, ViewAndProjectionAreThoseOfThePoseAndTheTangents) {
  for (int frame = 0; frame < 12; ++frame) {
    for (const EyeInFrame& eye : mock_xr::eyes_at(frame)) {
      const StereoScreen screen = look_through(eye, kDepths, kLight);
      for (const Eye any : {Eye::left, Eye::right, Eye::centre}) {
        EXPECT_TRUE(compute_projection_matrix(screen, any).isApprox(frustum_of(eye.fov, kDepths.near_m, kDepths.far_m), 1e-12));
        EXPECT_TRUE(compute_view_matrix(screen, any).isApprox(eye.X_FE.inverse().matrix(), 1e-12));
        EXPECT_LT((compute_eye_position(screen, any) - eye.X_FE.translation()).norm(), 1e-12);
      }
    }
  }
}

TEST(EyeFrustum, APointIsDrawnWhereItsTangentsAre) {
  constexpr PictureSize kSize{1600, 1760};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(-1.0, 1.0);
  for (int frame = 0; frame < 50; ++frame) {
    for (const EyeInFrame& eye : mock_xr::eyes_at(frame)) {
      const Vec3 p_E(anywhere(random), anywhere(random), -1.1 + anywhere(random));
      const double across = (p_E.x() / -p_E.z() - std::tan(eye.fov.left_rad)) / (std::tan(eye.fov.right_rad) - std::tan(eye.fov.left_rad));
      const double up = (p_E.y() / -p_E.z() - std::tan(eye.fov.down_rad)) / (std::tan(eye.fov.up_rad) - std::tan(eye.fov.down_rad));
      const Vec2 pixel = project_to_pixel(look_through(eye, kDepths, kLight), Eye::centre, kSize, eye.X_FE * p_E);
      EXPECT_NEAR(pixel.x(), across * kSize.width_px, 1e-6 * std::abs(across * kSize.width_px) + 1e-6);
      EXPECT_NEAR(pixel.y(), up * kSize.height_px, 1e-6 * std::abs(up * kSize.height_px) + 1e-6);
    }
  }
}

TEST(EyeFrustum, TheLightStaysInTheRoom) {
  for (const EyeInFrame& eye : mock_xr::eyes_at(5)) {
    const StereoScreen screen = look_through(eye, kDepths, kLight);
    EXPECT_LT((screen.X_WV.linear() * screen.light_V - kLight).norm(), 1e-12);
  }
}

TEST(EyeFrustum, TheDepthsHoldTheWorkspaceHoweverNearTheEyesAre) {
  Framing framing;
  framing.p_WC = Vec3(0.1, 0.0, -0.2);
  framing.depth_m = 0.4;
  for (const double away_m : {2.0, 0.6, 0.2, 0.01, 0.0}) {
    const HeadsetDepths depths = find_headset_depths(framing, framing.p_WC + away_m * Vec3(0.0, 0.6, 0.8));
    EXPECT_GT(depths.near_m, 0.0);
    EXPECT_LE(depths.near_m, 0.021) << "a hand before the face is seen";
    EXPECT_LT(depths.near_m, depths.plane_m);
    EXPECT_GE(depths.far_m, away_m + framing.depth_m);
    EXPECT_GE(depths.plane_m, away_m);
  }
}

TEST(EyeFrustum, FieldsOfViewThatShowNothingAreImpossible) {
  EXPECT_TRUE(is_possible(FieldOfView{}));
  EXPECT_TRUE(is_possible(FieldOfView{0.1, 0.8, 0.8, 0.2})) << "the axis may be outside of the picture";
  EXPECT_FALSE(is_possible(FieldOfView{0.8, -0.8, 0.8, -0.8}));
  EXPECT_FALSE(is_possible(FieldOfView{-0.8, 0.8, -0.8, 0.8}));
  EXPECT_FALSE(is_possible(FieldOfView{-1.6, 0.8, 0.8, -0.8}));
  EXPECT_FALSE(is_possible(FieldOfView{-0.8, 0.8, 1.6, -0.8}));
  EXPECT_FALSE(is_possible(FieldOfView{0.0, 0.0, 0.8, -0.8}));
  EXPECT_FALSE(is_possible(FieldOfView{std::numeric_limits<double>::quiet_NaN(), 0.8, 0.8, -0.8}));
}

}  // namespace
}  // namespace hapton
