#include "tools/check/reach_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <tuple>
#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(ReachCheck, CutsTrianglesAtTheBox) {
  const TriangleMesh square = make_plane_grid(2.0, 1);  // two triangles, x and y from -1 to 1
  const Vec3 far = Vec3::Constant(10.0);
  EXPECT_EQ(find_unreached(square, {-far, far}).share, 0.0);
  // Not reached: a fifth; all but the middle; all; and all but the part at one corner.
  EXPECT_NEAR(find_unreached(square, {-far, Vec3(0.6, 10, 10)}).share, 0.2, 1e-8);
  EXPECT_NEAR(find_unreached(square, {Vec3(-0.5, -0.5, -1), Vec3(0.5, 0.5, 1)}).share, 0.75, 1e-8);
  EXPECT_EQ(find_unreached(square, {Vec3(3, 3, 3), far}).share, 1.0);
  const Unreached corner = find_unreached(square, {Vec3(-10, -10, -10), Vec3(0.5, 0.25, 10)});
  EXPECT_EQ(corner.farthest, Vec3(1, 1, 0));
  EXPECT_NEAR(corner.distance_m, std::hypot(0.5, 0.75), 1e-7);
}

TEST(ReachCheck, WhatTouchesTheBoxIsInside) {
  const TriangleMesh box = make_box(Vec3(0.3, 0.2, 0.1), 2);
  EXPECT_EQ(find_unreached(box, {Vec3(-0.15, -0.1, -0.05), Vec3(0.15, 0.1, 0.05)}).share, 0.0);
}

// The share equals the share of random points of the surface that are outside.
TEST(ReachCheck, TheUnreachedShareIsThatOfRandomPoints) {
  constexpr unsigned kSeed = 77;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const TriangleMesh torus = make_torus(0.5, 0.2, 20, 10);
  const Vec3 low(-0.3, -0.6, -0.1);
  const Vec3 high(0.55, 0.2, 0.3);
  double total_area = 0.0;
  double outside_area = 0.0;
  for (std::size_t t = 0; t < torus.triangles.size(); ++t) {
    const Vec3 ab = torus.corner(t, 1) - torus.corner(t, 0);
    const Vec3 ac = torus.corner(t, 2) - torus.corner(t, 0);
    const double area = 0.5 * ab.cross(ac).norm();
    constexpr int kPointsPerTriangle = 400;
    int points_outside = 0;
    for (int i = 0; i < kPointsPerTriangle; ++i) {
      double u = uniform(random);
      double v = uniform(random);
      if (u + v > 1.0) std::tie(u, v) = std::pair(1.0 - u, 1.0 - v);
      const Vec3 p = torus.corner(t, 0) + u * ab + v * ac;
      points_outside += ((low - p).maxCoeff() > 0.0 || (p - high).maxCoeff() > 0.0) ? 1 : 0;
    }
    total_area += area;
    outside_area += area * points_outside / kPointsPerTriangle;
  }
  EXPECT_NEAR(find_unreached(torus, {low, high}).share, outside_area / total_area, 0.01);
}

// A plane through the middle of a ball: the disc of the ball is reached, the rest is not.
TEST(ReachCheck, CutsTrianglesAtTheBall) {
  const Vec3 middle(0.3, -0.2, 0.1);
  const Workspace ball{middle - Vec3::Constant(0.5), middle + Vec3::Constant(0.5), 0.5};
  for (const int cells : {1, 7, 300}) {
    const TriangleMesh square = scaled_and_moved(make_plane_grid(2.0, cells), 1.0, middle);
    EXPECT_NEAR(find_unreached(square, ball).share, 1.0 - M_PI * 0.25 / 4.0, 1e-3) << cells;
    EXPECT_NEAR(find_unreached(square, ball).distance_m, std::sqrt(2.0) - 0.5, 1e-7);
    const TriangleMesh above = scaled_and_moved(make_plane_grid(2.0, cells), 1.0, middle + Vec3(0, 0, 0.3));
    EXPECT_NEAR(find_unreached(above, ball).share, 1.0 - M_PI * 0.16 / 4.0, 1e-3) << cells;  // a disc of radius 0.4
  }
  EXPECT_EQ(find_unreached(scaled_and_moved(make_plane_grid(0.7, 1), 1.0, middle), ball).share, 0.0) << "corners at 0.495";
  EXPECT_EQ(find_unreached(scaled_and_moved(make_plane_grid(2.0, 1), 1.0, middle + Vec3(0, 0, 0.6)), ball).share, 1.0);
}

// A cube that just fits into the box of a ball has its corners outside the ball.
TEST(ReachCheck, TheCornersOfABallsBoxAreNotReached) {
  const DevicePreset& touch = *find_device_preset("touch");
  SceneObject cube;
  cube.name = "cube";
  cube.mesh = std::make_shared<const TriangleMesh>(make_box(Vec3::Constant(0.149), 4));
  const CheckFindings findings = check_reach(cube, touch);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_NE(findings[0].what.find("outside the workspace of touch, up to 54"), std::string::npos) << findings[0].what;
  cube.mesh = std::make_shared<const TriangleMesh>(make_box(Vec3::Constant(0.086), 4));
  EXPECT_TRUE(check_reach(cube, touch).empty());
  EXPECT_TRUE(check_reach(cube, *find_device_preset("falcon")).empty());
}

SceneEffect snap_at(SnapEffect::Target target, const Vec3& position, const Vec3& direction = Vec3::UnitZ()) {
  return {.name = "pull", .effect = SnapEffect{.target = target, .position = position, .direction = direction, .range_m = 0.02}};
}

TEST(ReachCheck, ASnapOutOfReachIsFound) {
  using Target = SnapEffect::Target;
  const DevicePreset& falcon = *find_device_preset("falcon");  // a cube, 50.8 mm from the middle to each side
  EXPECT_TRUE(check_reach(snap_at(Target::point, Vec3(0.07, 0, 0)), falcon).empty()) << "19.2 mm outside";
  const CheckFindings findings = check_reach(snap_at(Target::point, Vec3(3, 0, 0)), falcon);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::out_of_reach);
  EXPECT_EQ(findings[0].object, "effect pull");
  EXPECT_EQ(*findings[0].place_m, Vec3(3, 0, 0));
  EXPECT_EQ(findings[0].what, "pulls from within 20 mm, and lies 2949 mm outside the workspace of falcon: nobody can feel it");
  EXPECT_EQ(check_reach(snap_at(Target::point, Vec3(0.08, 0, 0)), *find_device_preset("touch")).size(), 0U) << "a ball of 75 mm";
  EXPECT_EQ(check_reach(snap_at(Target::point, Vec3(0.07, 0.07, 0)), *find_device_preset("touch")).size(), 1U);
  EXPECT_TRUE(check_reach(snap_at(Target::line, Vec3(0, 0, 3)), falcon).empty()) << "it passes through";
  EXPECT_EQ(check_reach(snap_at(Target::line, Vec3(0.2, 0, 3)), falcon).size(), 1U);
  EXPECT_TRUE(check_reach(snap_at(Target::plane, Vec3(3, 0, 0.1)), falcon).empty());
  EXPECT_EQ(check_reach(snap_at(Target::plane, Vec3(0, 0, 0.2)), falcon).size(), 1U);
  EXPECT_TRUE(check_reach({.name = "wind", .effect = ConstantEffect{}}, falcon).empty());
}

TEST(ReachCheck, AVolumeOutOfReachIsFound) {
  const DevicePreset& falcon = *find_device_preset("falcon");  // a cube, 50.8 mm from the middle to each side
  const auto wind_in = [](const EffectVolume& volume) { return SceneEffect{.name = "wind", .effect = ConstantEffect{.volume = volume}}; };
  EXPECT_TRUE(check_reach(wind_in(EffectVolume::ball(Vec3(0.1, 0, 0), 0.05)), falcon).empty());
  const CheckFindings findings = check_reach(wind_in(EffectVolume::ball(Vec3(0.1, 0, 0), 0.01)), falcon);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::out_of_reach);
  EXPECT_EQ(findings[0].object, "effect wind");
  EXPECT_EQ(findings[0].what, "acts in a volume 39.2 mm outside the workspace of falcon: nobody can feel it");
  EXPECT_TRUE(check_reach(wind_in(EffectVolume::box(Vec3(0.05, -1, -1), Vec3(2, 1, 1))), falcon).empty());
  EXPECT_EQ(check_reach(wind_in(EffectVolume::box(Vec3(0.06, -1, -1), Vec3(2, 1, 1))), falcon).size(), 1U);
  const DevicePreset& touch = *find_device_preset("touch");  // a ball of radius 75 mm
  EXPECT_TRUE(check_reach(wind_in(EffectVolume::box(Vec3(0.05, 0.05, -1), Vec3(2, 2, 1))), touch).empty()) << "0.0707 from its middle";
  EXPECT_EQ(check_reach(wind_in(EffectVolume::box(Vec3(0.054, 0.054, -1), Vec3(2, 2, 1))), touch).size(), 1U) << "0.0764 from its middle";
}

TEST(ReachCheck, AGravityWellOutOfReachIsFound) {
  const DevicePreset& falcon = *find_device_preset("falcon");
  const auto well_at = [](double x_m) {
    return SceneEffect{.name = "well", .effect = GravityWellEffect{.centre = Vec3(x_m, 0, 0), .radius_m = 0.01, .max_force_n = 2.0}};
  };
  EXPECT_TRUE(check_reach(well_at(0.06), falcon).empty());
  const CheckFindings findings = check_reach(well_at(2.0), falcon);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::out_of_reach);
  EXPECT_EQ(findings[0].object, "effect well");
}

// A cube of 40 mm that goes out to the right and comes back.
TEST(ReachCheck, AMotionOutOfReachIsFound) {
  const DevicePreset& falcon = *find_device_preset("falcon");
  SceneObject cube;
  cube.name = "cube";
  cube.mesh = std::make_shared<const TriangleMesh>(make_box(Vec3::Constant(0.04), 1));
  EXPECT_TRUE(check_reach(cube, falcon).empty());
  const auto going_to = [](double x_m) {
    return std::make_shared<const KeyframeMotion>(
        Vec3::Zero(),
        std::vector<Keyframe>{
            {0.0, Vec3::Zero(), Quat::Identity()}, {1.5, Vec3(x_m, 0, 0), Quat::Identity()}, {3.0, Vec3::Zero(), Quat::Identity()}},
        true);
  };
  cube.motion = going_to(0.03);
  EXPECT_TRUE(check_reach(cube, falcon).empty());
  cube.motion = going_to(0.06);
  const CheckFindings findings = check_reach(cube, falcon);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::out_of_reach);
  // Outside are one face of six, and 29.2 of the 40 mm of four others.
  EXPECT_EQ(findings[0].what, "at 1.5 s 65 % of its surface lies outside the workspace of falcon, up to 29.2 mm");
  cube.motion = going_to(1.0);
  EXPECT_EQ(check_reach(cube, falcon).at(0).what, "at 1.5 s all of it lies outside the workspace of falcon, up to 969 mm");
}

TEST(ReachCheck, AMeshWithoutAreaCountsByItsVertices) {
  TriangleMesh line;
  line.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(4, 0, 0), Vec3(5, 0, 0)};
  line.triangles = {{0, 1, 2}, {1, 2, 3}};
  EXPECT_EQ(find_unreached(line, {Vec3(-1, -1, -1), Vec3(2, 1, 1)}).share, 0.5);
}

}  // namespace
}  // namespace hapton
