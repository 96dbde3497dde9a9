#include "vision_node/camera_view.h"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr PictureSize kPicture{640, 480};
const Framing kHome = frame_sphere(Vec3::Zero(), 0.12, 0.063);

Vec2 pixel_of(const CameraView& camera, const Vec3& p_W, Eye eye = Eye::centre) {
  return project_to_pixel(compute_screen(camera.apply(kHome), kPicture), eye, kPicture, p_W);
}

TEST(CameraView, BeginsAsTheFramingIs) {
  const CameraView camera;
  EXPECT_EQ(pixel_of(camera, Vec3(0.01, 0.02, 0.03)),
            project_to_pixel(compute_screen(kHome, kPicture), Eye::centre, kPicture, Vec3(0.01, 0.02, 0.03)));
}

TEST(CameraView, ZoomMakesThePictureThatManyTimesAsLargeAndKeepsItsDepth) {
  CameraView camera;
  camera.zoom_by(2.0);
  const Vec2 centre(320.0, 240.0);
  const Vec3 p_W(0.02, 0.01, 0.0);
  EXPECT_LT((pixel_of(camera, p_W) - centre - 2.0 * (pixel_of({}, p_W) - centre)).norm(), 1e-9);
  const Vec3 near_W(0.0, 0.0, 0.05);
  const double before = pixel_of({}, near_W, Eye::right).x() - pixel_of({}, near_W, Eye::left).x();
  const double after = pixel_of(camera, near_W, Eye::right).x() - pixel_of(camera, near_W, Eye::left).x();
  EXPECT_NEAR(after, before, 1e-9);
}

TEST(CameraView, ZoomHasLimitsAndIgnoresInvalidFactors) {
  CameraView camera;
  for (int i = 0; i < 1000; ++i) camera.zoom_by(1.1);
  EXPECT_EQ(camera.zoom, 100.0);
  for (int i = 0; i < 1000; ++i) camera.zoom_by(0.9);
  EXPECT_EQ(camera.zoom, 0.1);
  for (const double factor : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    camera.zoom_by(factor);
    EXPECT_EQ(camera.zoom, 0.1);
  }
}

TEST(CameraView, OrbitGoesRoundTheCentreAndNeverOverThePole) {
  CameraView camera;
  camera.orbit(0.5, 0.0);
  EXPECT_LT((pixel_of(camera, Vec3::Zero()) - Vec2(320.0, 240.0)).norm(), 1e-9);
  EXPECT_LT(pixel_of(camera, Vec3(0.0, 0.0, 0.1)).x(), 320.0) << "from the right, what is in front lies to the left";
  camera.orbit(0.0, 100.0);
  EXPECT_LT(camera.apply(kHome).pitch_rad, 0.5 * std::numbers::pi);
  camera.orbit(0.0, -100.0);
  EXPECT_GT(camera.apply(kHome).pitch_rad, -0.5 * std::numbers::pi);
}

TEST(CameraView, PanMovesThePictureAndCutsNothingOff) {
  CameraView camera;
  camera.pan_m = Vec3(0.1, 0.0, 0.0);
  EXPECT_LT((pixel_of(camera, Vec3(0.1, 0.0, 0.0)) - Vec2(320.0, 240.0)).norm(), 1e-9);
  const Framing moved = camera.apply(kHome);
  EXPECT_GE(moved.depth_m, kHome.depth_m + 0.1) << "what lay at the edge of the depth still does";
}

TEST(CameraView, LookAtFillsThePictureWithTheSphere) {
  CameraView camera;
  const Vec3 p_WO(0.03, -0.02, 0.01);
  camera.look_at(kHome, p_WO, 0.02);
  EXPECT_LT((pixel_of(camera, p_WO) - Vec2(320.0, 240.0)).norm(), 1e-9);
  const double radius_px = pixel_of(camera, p_WO + Vec3(0.02, 0.0, 0.0)).x() - 320.0;
  EXPECT_GT(radius_px, 200.0);
  EXPECT_LT(radius_px, 240.0);
  Framing moved = kHome;
  moved.centre_offset_m = Vec2(0.02, -0.01);
  EXPECT_LT((project_to_pixel(compute_screen(camera.apply(moved), kPicture), Eye::centre, kPicture, p_WO) - Vec2(320.0, 240.0)).norm(),
            1e-9);
  const CameraView before = camera;
  camera.look_at(kHome, p_WO, 0.0);
  EXPECT_EQ(camera, before) << "a scene of one point has no size to go by";
}

}  // namespace
}  // namespace hapton
