#include "vision_node/stereo_camera.h"

#include <random>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr PictureSize kSize{640, 720};

Framing tilted() {
  Framing framing = frame_sphere({0.02, -0.03, 0.05}, 0.14, 0.063);
  framing.yaw_rad = 0.3;
  framing.pitch_rad = 0.4;
  return framing;
}

// The pixel of a point, from the matrices that the graphics card gets: clip = P V p.
Vec2 pixel_by_matrices(const StereoScreen& screen, Eye eye, const Vec3& p_W) {
  const Eigen::Vector4d clip = compute_projection_matrix(screen, eye) * compute_view_matrix(screen, eye) * p_W.homogeneous();
  return {(clip.x() / clip.w() + 1.0) * 0.5 * kSize.width_px, (clip.y() / clip.w() + 1.0) * 0.5 * kSize.height_px};
}

TEST(StereoCamera, CentreOfWorkspaceIsInTheMiddleOfBothEyesPictures) {
  const Framing framing = tilted();
  const StereoScreen screen = compute_screen(framing, kSize);
  for (const Eye eye : {Eye::left, Eye::right, Eye::centre}) {
    const Vec2 pixel = pixel_by_matrices(screen, eye, framing.p_WC);
    EXPECT_NEAR(pixel.x(), 320.0, 1e-9);
    EXPECT_NEAR(pixel.y(), 360.0, 1e-9);
  }
}

TEST(StereoCamera, CornersOfTheScreenAreCornersOfBothPictures) {
  const StereoScreen screen = compute_screen(tilted(), kSize);
  for (const Eye eye : {Eye::left, Eye::right}) {
    for (const double sx : {-1.0, 1.0}) {
      for (const double sy : {-1.0, 1.0}) {
        const Vec3 corner = screen.X_WV * Vec3(0.5 * sx * screen.width_m, 0.5 * sy * screen.height_m, 0.0);
        const Vec2 pixel = pixel_by_matrices(screen, eye, corner);
        EXPECT_NEAR(pixel.x(), 0.5 * (1.0 + sx) * kSize.width_px, 1e-8);
        EXPECT_NEAR(pixel.y(), 0.5 * (1.0 + sy) * kSize.height_px, 1e-8);
      }
    }
  }
}

// A point is drawn where the straight line from the eye to the point crosses the screen; here computed without any matrix.
TEST(StereoCamera, MatricesAgreeWithTheRayThroughTheScreen) {
  constexpr std::uint64_t kSeed = 7;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.15, 0.15);
  const StereoScreen screen = compute_screen(tilted(), kSize);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p_V(coordinate(random), coordinate(random), coordinate(random));
    for (const Eye eye : {Eye::left, Eye::right}) {
      // The eye: half of the distance between the pupils from the middle, which tilted() sets to 0.063 m.
      const Vec3 e(eye == Eye::left ? -0.0315 : 0.0315, 0.0, screen.distance_m);
      const double share = e.z() / (e.z() - p_V.z());
      const Vec3 hit = e + share * (p_V - e);
      const Vec2 expected((hit.x() / screen.width_m + 0.5) * kSize.width_px, (hit.y() / screen.height_m + 0.5) * kSize.height_px);
      const Vec3 p_W = screen.X_WV * p_V;
      EXPECT_LT((pixel_by_matrices(screen, eye, p_W) - expected).norm(), 1e-7) << "seed " << kSeed << ", point " << i;
      EXPECT_LT((project_to_pixel(screen, eye, kSize, p_W) - expected).norm(), 1e-7);
    }
  }
}

TEST(StereoCamera, DisparityIsZeroOnTheScreenCrossedInFrontAndBelowIpdBehind) {
  const StereoScreen screen = compute_screen(tilted(), kSize);
  const double pixels_per_metre = kSize.width_px / screen.width_m;
  for (const double z : {-100.0, -0.3, -0.1, 0.0, 0.1, 0.3}) {
    const Vec3 p_W = screen.X_WV * Vec3(0.03, -0.02, z);
    const double measured = pixel_by_matrices(screen, Eye::right, p_W).x() - pixel_by_matrices(screen, Eye::left, p_W).x();
    EXPECT_NEAR(measured, compute_disparity_m(screen, z) * pixels_per_metre, 1e-7) << z;
    EXPECT_NEAR(pixel_by_matrices(screen, Eye::right, p_W).y(), pixel_by_matrices(screen, Eye::left, p_W).y(), 1e-8);
  }
  EXPECT_EQ(compute_disparity_m(screen, 0.0), 0.0);
  EXPECT_LT(compute_disparity_m(screen, 0.1), 0.0);
  EXPECT_GT(compute_disparity_m(screen, -0.1), 0.0);
  EXPECT_LT(compute_disparity_m(screen, -1e6), screen.ipd_m);
  // From a point half way to the eyes, the lines of sight meet the screen one ipd apart, crossed.
  EXPECT_NEAR(compute_disparity_m(screen, 0.5 * screen.distance_m), -screen.ipd_m, 1e-12);
}

TEST(StereoCamera, DepthRangeIsOpenGls) {
  const StereoScreen screen = compute_screen(tilted(), kSize);
  const Mat4 P = compute_projection_matrix(screen, Eye::left);
  for (const auto& [depth, ndc] : {std::pair(screen.near_m, -1.0), std::pair(screen.far_m, 1.0)}) {
    const Eigen::Vector4d clip = P * Eigen::Vector4d(0.01, 0.02, -depth, 1.0);
    EXPECT_NEAR(clip.z() / clip.w(), ndc, 1e-9);
  }
}

TEST(StereoCamera, PixelsAreSquareAtEveryAspect) {
  for (const PictureSize size : {PictureSize{640, 720}, {1280, 720}, {300, 900}, {1, 1}}) {
    const StereoScreen screen = compute_screen(tilted(), size);
    EXPECT_NEAR(screen.width_m / size.width_px, screen.height_m / size.height_px, 1e-15);
    EXPECT_NEAR(std::min(screen.width_m, screen.height_m), tilted().view_m, 1e-15);
  }
}

TEST(StereoCamera, FramedSphereIsWhollyInsideThePictureOfEveryEye) {
  constexpr std::uint64_t kSeed = 11;
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  for (const double radius : {1e-5, 0.01, 0.14, 0.2, 3.0, 1e5}) {
    const Framing framing = frame_sphere(Vec3::Zero(), radius, 0.063);
    const StereoScreen screen = compute_screen(framing, kSize);
    EXPECT_LT(screen.near_m, framing.distance_m - radius);
    EXPECT_GT(screen.far_m, framing.distance_m + radius);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p = radius * Vec3(normal(random), normal(random), normal(random)).normalized();
      const Vec2 pixel = pixel_by_matrices(screen, Eye::centre, p);
      ASSERT_TRUE(pixel.x() > 0.0 && pixel.x() < 640.0 && pixel.y() > 0.0 && pixel.y() < 720.0) << "radius " << radius << " seed " << kSeed;
    }
  }
}

// Drawing is in single precision: however small the scene, points a pixel apart must have different coordinates relative to the eye.
TEST(StereoCamera, ResolvesPixelsOfASmallScene) {
  for (const double radius : {1e-6, 1e-5, 1e-4, 1e-3, 0.1}) {
    const Framing framing = frame_sphere(Vec3::Zero(), radius, 0.063);
    const double pixel_m = framing.view_m / 720.0;
    const auto eye = static_cast<float>(framing.distance_m);
    EXPECT_GT(pixel_m, 20.0 * static_cast<double>(std::nextafter(eye, 2.0F * eye) - eye)) << radius;
  }
}

TEST(StereoCamera, YawMovesTheViewerRightAndPitchUp) {
  Framing framing;
  framing.yaw_rad = 0.3;
  const Vec3 right = compute_eye_position(compute_screen(framing, kSize), Eye::centre);
  EXPECT_GT(right.x(), 0.1);
  EXPECT_NEAR(right.norm(), framing.distance_m, 1e-12);
  framing.yaw_rad = 0.0;
  framing.pitch_rad = 0.3;
  EXPECT_GT(compute_eye_position(compute_screen(framing, kSize), Eye::centre).y(), 0.1);
}

TEST(StereoCamera, DisplacementInTheScreenPlaneMovesByThatManyPixels) {
  const StereoScreen screen = compute_screen(tilted(), kSize);
  for (const double z : {-0.2, 0.0, 0.2}) {
    const Vec3 from = screen.X_WV * Vec3(0.01, 0.02, z);
    const Vec3 to = from + displace_in_screen_plane(screen, kSize, {12.0, -7.0}, z);
    const Vec2 moved = pixel_by_matrices(screen, Eye::left, to) - pixel_by_matrices(screen, Eye::left, from);
    EXPECT_NEAR(moved.x(), 12.0, 1e-8);
    EXPECT_NEAR(moved.y(), -7.0, 1e-8);
  }
}

TEST(StereoScreen, MovedAsideShowsThatPlaceInItsMiddleWithoutParallax) {
  Framing framing = frame_sphere({0.02, -0.03, 0.05}, 0.14, 0.063);
  framing.yaw_rad = 0.3;
  framing.pitch_rad = -0.2;
  const StereoScreen before = compute_screen(framing, {800, 600});
  const Vec3 p_W = before.X_WV * Vec3(0.01, 0.03, 0.0);
  framing.centre_offset_m = Vec2(0.01, 0.03);
  for (const Eye eye : {Eye::left, Eye::right}) {
    EXPECT_LT((project_to_pixel(compute_screen(framing, {800, 600}), eye, {800, 600}, p_W) - Vec2(400.0, 300.0)).norm(), 1e-9);
    EXPECT_LT((project_to_pixel(before, eye, {800, 600}, framing.p_WC) - Vec2(400.0, 300.0)).norm(), 1e-9);
  }
}

// Heads in front of the screen: in the middle, left, right and up, near, far, tilted, turned, and all of these together.
std::vector<Head> some_heads() {
  const auto turn = [](double about_x, double about_y, double about_z) {
    return Quat(Eigen::AngleAxisd(about_z, Vec3::UnitZ()) * Eigen::AngleAxisd(about_y, Vec3::UnitY()) *
                Eigen::AngleAxisd(about_x, Vec3::UnitX()));
  };
  return {{},
          {{-0.2, 0.0, 0.6}, Quat::Identity()},
          {{0.15, 0.12, 0.55}, Quat::Identity()},
          {{0.0, 0.0, 0.3}, Quat::Identity()},
          {{0.1, -0.05, 1.4}, Quat::Identity()},
          {{0.0, 0.0, 0.6}, turn(0.0, 0.0, 0.4)},
          {{0.0, 0.0, 0.6}, turn(0.2, 0.7, 0.0)},
          {{-0.1, 0.1, 0.4}, turn(-0.3, 0.5, -0.6)}};
}

// Computed here without matrices: the eyes as the head's pose places them, in the world, and the straight line from each to the point.
TEST(StereoCamera, AHeadAnywhereSeesThroughTheSameScreen) {
  constexpr std::uint64_t kSeed = 23;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.13, 0.13);
  for (const double screen_width_m : {0.0, 0.3, 1.1}) {
    for (const Head& head : some_heads()) {
      Framing framing = tilted();
      framing.head = head;
      framing.screen_width_m = screen_width_m;
      const StereoScreen screen = compute_screen(framing, kSize);
      const double scale = screen_width_m > 0.0 ? screen.width_m / screen_width_m : 1.0;
      for (const Eye eye : {Eye::left, Eye::right, Eye::centre}) {
        const double side = eye == Eye::left ? -1.0 : eye == Eye::right ? 1.0 : 0.0;
        const Vec3 e = scale * (head.p_RH + side * 0.0315 * (head.q_RH * Vec3::UnitX()));
        EXPECT_LT((compute_eye_position(screen, eye) - screen.X_WV * e).norm(), 1e-12);
        EXPECT_NEAR(compute_eye_depths(screen, eye).eye_m, e.z(), 1e-12);
        for (int i = 0; i < 100; ++i) {
          const Vec3 p_V(coordinate(random), coordinate(random), std::min(coordinate(random), 0.7 * e.z()));
          const Vec3 hit = e + e.z() / (e.z() - p_V.z()) * (p_V - e);
          const Vec2 expected((hit.x() / screen.width_m + 0.5) * kSize.width_px, (hit.y() / screen.height_m + 0.5) * kSize.height_px);
          const Vec3 p_W = screen.X_WV * p_V;
          ASSERT_LT((pixel_by_matrices(screen, eye, p_W) - expected).norm(), 1e-6) << "seed " << kSeed;
          ASSERT_LT((project_to_pixel(screen, eye, kSize, p_W) - expected).norm(), 1e-6) << "seed " << kSeed;
        }
      }
    }
  }
}

TEST(StereoCamera, EachEyesDepthsEndAtTheSamePlanes) {
  for (const Head& head : some_heads()) {
    Framing framing = frame_sphere(Vec3::Zero(), 0.05, 0.063);
    framing.head = head;
    const StereoScreen screen = compute_screen(framing, kSize);
    for (const Eye eye : {Eye::left, Eye::right}) {
      const auto [eye_m, near_m, far_m] = compute_eye_depths(screen, eye);
      EXPECT_GT(near_m, 0.0);
      EXPECT_NEAR(eye_m - far_m, -framing.depth_m, 1e-12) << "everything behind the screen";
      const double in_front_m = std::min(framing.depth_m, 0.95 * std::min(eye_m, screen.distance_m));
      EXPECT_GT(eye_m - near_m, in_front_m - 1e-12) << "and in front of it, except at the eyes";
      const Mat4 P = compute_projection_matrix(screen, eye);
      for (const auto& [depth, ndc] : {std::pair(near_m, -1.0), std::pair(far_m, 1.0)}) {
        const Eigen::Vector4d clip = P * Eigen::Vector4d(0.01, 0.02, -depth, 1.0);
        EXPECT_NEAR(clip.z() / clip.w(), ndc, 1e-9);
      }
    }
  }
}

TEST(StereoCamera, WithoutAHeadNothingChanges) {
  for (const double radius : {1e-4, 0.1, 3.0}) {
    const Framing framing = frame_sphere(Vec3::Zero(), radius, 0.063);
    const StereoScreen screen = compute_screen(framing, kSize);
    EXPECT_EQ(screen.distance_m, framing.distance_m);
    EXPECT_EQ(screen.ipd_m, framing.ipd_m);
    EXPECT_TRUE(screen.eyes_offset_m.isZero(0.0));
  }
}

// A model of half the size on a screen of half the size, seen by a viewer of half the size, is the same picture.
TEST(StereoCamera, AKnownScreenScalesTheViewerLikeThePicture) {
  Framing framing = frame_sphere(Vec3::Zero(), 0.1, 0.06);
  framing.head = {{0.05, -0.02, 0.5}, Quat(Eigen::AngleAxisd(0.2, Vec3::UnitZ()))};
  framing.screen_width_m = 0.4;
  const StereoScreen screen = compute_screen(framing, kSize);
  EXPECT_NEAR(screen.ipd_m / screen.width_m, 0.06 / 0.4, 1e-15);
  EXPECT_NEAR(screen.distance_m / screen.width_m, 0.5 / 0.4, 1e-15);
  EXPECT_NEAR(screen.eyes_offset_m.x() / screen.width_m, 0.05 / 0.4, 1e-15);
  EXPECT_NEAR(compute_viewer_scale(framing, screen.width_m), screen.width_m / 0.4, 1e-15);
  Framing larger = framing;
  larger.view_m *= 2.0;
  const Vec3 p_W(0.03, 0.02, 0.04);
  for (const Eye eye : {Eye::left, Eye::right}) {
    EXPECT_LT((project_to_pixel(screen, eye, kSize, p_W) - project_to_pixel(compute_screen(larger, kSize), eye, kSize, 2.0 * p_W)).norm(),
              1e-9);
  }
}

TEST(StereoCamera, ImpossibleHeadsAreKnown) {
  const Quat straight = Quat::Identity();
  const Quat sideways(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()));
  EXPECT_TRUE(is_possible({}, 0.063));
  EXPECT_TRUE(is_possible({{0, 0, 0.0501}, straight}, 0.2));
  EXPECT_FALSE(is_possible({{0, 0, 0.0501}, sideways}, 0.063)) << "one eye in the screen";
  EXPECT_TRUE(is_possible({{0, 0, 0.09}, sideways}, 0.063));
  EXPECT_FALSE(is_possible({{0, 0, 0.0499}, straight}, 0.0));
  EXPECT_FALSE(is_possible({{0, 0, -0.6}, straight}, 0.063));
  EXPECT_FALSE(is_possible({{0, 101.0, 0.6}, straight}, 0.063));
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_possible({{0, 0, kNaN}, straight}, 0.063));
  EXPECT_FALSE(is_possible({{kNaN, 0, 0.6}, straight}, 0.063));
}

}  // namespace
}  // namespace hapton
