#include "core/geometry/touch_trajectory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

double distance_to_mesh(const TriangleMesh& mesh, const Vec3& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    nearest = std::min(nearest, closest_point(mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2), p).distance);
  return nearest;
}

TEST(TouchTrajectory, SlideHasTheDocumentedDepthAndSpeed) {
  const TriangleMesh mesh = make_icosphere(0.05, 5);
  const auto slide = make_slide_trajectory(mesh, {.seed = 3});
  ASSERT_TRUE(slide.has_value());
  ASSERT_EQ(slide->p_SD.size(), 20000u);
  EXPECT_EQ(slide->reset_every, 4000u);
  for (std::size_t segment = 0; segment < 5; ++segment) {
    const Vec3* rows = &slide->p_SD[segment * 4000];
    EXPECT_NEAR(rows[0].norm(), 0.05 + 0.005, 2e-4);
    EXPECT_NEAR(rows[199].norm(), 0.05 - 0.0015, 1e-4);
    double least_depth = 1.0, greatest_depth = 0.0;
    for (int i = 300; i < 4000; ++i) {
      ASSERT_LT((rows[i] - rows[i - 1]).norm(), 1.6e-4);
      least_depth = std::min(least_depth, 0.05 - rows[i].norm());
      greatest_depth = std::max(greatest_depth, 0.05 - rows[i].norm());
    }
    EXPECT_NEAR(least_depth, 0.001, 1e-4);
    EXPECT_NEAR(greatest_depth, 0.002, 1e-4);
    double path_m = 0.0;
    for (int i = 1000; i < 3000; ++i) path_m += (rows[i] - rows[i - 1]).norm();
    EXPECT_NEAR(path_m / 2.0, 0.1, 0.01);  // m/s: 2000 steps take two seconds
  }
}

TEST(TouchTrajectory, LengthsFollowTheMeshAndSeedsMatter) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.2, 1000, 1);
  const auto one = make_slide_trajectory(mesh, {.seed = 5, .rows = 5000});
  const auto same = make_slide_trajectory(mesh, {.seed = 5, .rows = 5000});
  const auto other = make_slide_trajectory(mesh, {.seed = 6, .rows = 5000});
  const auto large = make_slide_trajectory(scaled_and_moved(mesh, 1024.0, Vec3::Zero()), {.seed = 5, .rows = 5000});
  EXPECT_EQ(one->p_SD, same->p_SD);
  EXPECT_NE(one->p_SD, other->p_SD);
  for (std::size_t i = 0; i < one->p_SD.size(); ++i) ASSERT_LT((1024.0 * one->p_SD[i] - large->p_SD[i]).norm(), 1e-6);
}

TEST(TouchTrajectory, FreeNeverTouches) {
  for (const TriangleMesh& mesh :
       {make_icosphere(0.05, 4), make_box(Vec3(0.1, 0.05, 0.03)), make_torus(0.04, 0.01, 40, 20), make_gutter(0.1, 0.03, 0.6, 3)}) {
    const auto free = make_free_trajectory(mesh, {.seed = 2, .rows = 4000});
    ASSERT_TRUE(free.has_value());
    for (std::size_t i = 0; i < free->p_SD.size(); i += 10) ASSERT_GT(distance_to_mesh(mesh, free->p_SD[i]), 0.0005);
  }
}

TEST(TouchTrajectory, FreeOrbitsASphereAtOneToElevenMillimetres) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const auto free = make_free_trajectory(mesh, {.seed = 2, .rows = 8000});
  double least_height = 1.0, greatest_height = 0.0;
  for (const Vec3& p : free->p_SD) {
    least_height = std::min(least_height, p.norm() - 0.05);
    greatest_height = std::max(greatest_height, p.norm() - 0.05);
  }
  EXPECT_NEAR(least_height, 0.001, 3e-4);
  EXPECT_NEAR(greatest_height, 0.011, 3e-4);
  EXPECT_LT((free->p_SD[0] - free->p_SD[4000]).norm(), 0.011);
}

// Two small triangles, opposite each other, far from the axis: around each the path keeps their full distance for eleven sectors (half
// degrees) to both sides, then it falls evenly to zero over 21. Of two more triangles no point is within 12 mm of the middle height.
TEST(TouchTrajectory, FreeGoesAroundATriangleInGoodTime) {
  constexpr double kRadiusM = 0.05;
  const auto corner = [](double sector, double radius_m, double z_m) {
    const double angle = (sector / 360.0 - 1.0) * std::numbers::pi;
    return Vec3(radius_m * std::cos(angle), radius_m * std::sin(angle), z_m);
  };
  TriangleMesh mesh;
  const auto add_with_opposite = [&mesh](const std::array<Vec3, 3>& corners) {
    for (const double sign : {1.0, -1.0}) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const Vec3& p : corners) mesh.vertices.push_back(sign * p);
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
  };
  add_with_opposite({corner(100.7, 0.8 * kRadiusM, 0.0), corner(103.4, 0.9 * kRadiusM, 0.0), corner(102.0, kRadiusM, 0.001)});
  const double mm = compute_bounds(mesh).extent() / 100.0;
  add_with_opposite(
      {corner(250.0, 0.9 * kRadiusM, 12.1 * mm), corner(253.0, 0.9 * kRadiusM, 12.1 * mm), corner(252.0, 0.8 * kRadiusM, 13.0 * mm)});
  ASSERT_EQ(compute_bounds(mesh).extent() / 100.0, mm);
  const auto free = make_free_trajectory(mesh, {.seed = 2, .rows = 4000});
  ASSERT_TRUE(free.has_value());
  for (std::size_t i = 0; i < free->p_SD.size(); ++i) {
    const Vec3& p = free->p_SD[i];
    const double height_m = (6.0 - 5.0 * std::cos(2.0 * std::numbers::pi * 0.001 * static_cast<double>(i) / 1.7)) * mm;
    const double sector = std::fmod((std::atan2(p.y(), p.x()) / std::numbers::pi + 1.0) * 360.0, 360.0);
    // The triangle is in the sectors 100 to 103; one more on both sides is added.
    const double beside = std::max(99.0 - sector, sector - 104.0);
    ASSERT_NEAR(p.norm() - height_m, kRadiusM * std::clamp((31.0 - beside) / 21.0, 0.0, 1.0), 1e-9) << "at sector " << sector;
  }
}

TEST(TouchTrajectory, TapsEndInsideAndStartOutside) {
  const TriangleMesh mesh = make_icosphere(0.05, 3);
  const auto taps = make_tap_trajectory(mesh, {.seed = 2, .rows = 4000});
  ASSERT_EQ(taps->reset_every, 40u);
  for (std::size_t i = 0; i < 4000; i += 40) {
    EXPECT_NEAR(distance_to_mesh(mesh, taps->p_SD[i]), 0.005, 5e-4);
    EXPECT_NEAR(distance_to_mesh(mesh, taps->p_SD[i + 20]), 0.0015, 2e-4);
    EXPECT_LT(taps->p_SD[i + 20].norm(), 0.049);
  }
}

// Two blocks with a gap between them that is narrower than an approach is long: one side of each block faces the gap.
TEST(TouchTrajectory, TapsBeginWhereThePathToTheSurfaceIsFree) {
  const Vec3 size(0.04, 0.1, 0.1);
  const double centre_x = 0.5 * 0.04 + 0.5 * 0.002;
  const TriangleMesh block = make_box(size, 3);
  const TriangleMesh blocks =
      joined(scaled_and_moved(block, 1.0, {-centre_x, 0.0, 0.0}), scaled_and_moved(block, 1.0, {centre_x, 0.0, 0.0}));
  const auto is_within = [&](const Vec3& p, double x) { return ((p - Vec3(x, 0, 0)).cwiseAbs().array() < 0.5 * size.array()).all(); };
  const auto taps = make_tap_trajectory(blocks, {.seed = 4, .rows = 12000});
  ASSERT_TRUE(taps.has_value());
  for (std::size_t i = 0; i < taps->p_SD.size(); i += taps->reset_every) {
    const Vec3& start = taps->p_SD[i];
    const Vec3& deepest = taps->p_SD[i + 20];
    EXPECT_FALSE(is_within(start, -centre_x) || is_within(start, centre_x)) << i;
    if (3 * i >= taps->p_SD.size()) continue;  // the later taps are at vertices and edges
    EXPECT_NE(is_within(deepest, -centre_x), is_within(deepest, centre_x)) << i;
    // On the way to the deepest point, the tap is never in the other block.
    const double other_x = is_within(deepest, centre_x) ? -centre_x : centre_x;
    for (std::size_t k = 0; k < 20; ++k) EXPECT_FALSE(is_within(taps->p_SD[i + k], other_x)) << i + k;
  }
  const auto slide = make_slide_trajectory(blocks, {.seed = 4, .rows = 40000});
  ASSERT_TRUE(slide.has_value());
  for (std::size_t i = 0; i < slide->p_SD.size(); i += slide->reset_every) {
    const Vec3& start = slide->p_SD[i];
    EXPECT_FALSE(is_within(start, -centre_x) || is_within(start, centre_x)) << i;
  }
}

TEST(TouchTrajectory, RandomWalkStaysNearAndVisitsTheInside) {
  const TriangleMesh mesh = make_icosphere(0.05, 3);
  const auto walk = make_random_walk(mesh, {.seed = 2});
  std::size_t inside = 0;
  for (std::size_t i = 0; i < walk->p_SD.size(); ++i) {
    ASSERT_LE(walk->p_SD[i].cwiseAbs().maxCoeff(), 0.066);
    if (i > 0) {
      ASSERT_LT((walk->p_SD[i] - walk->p_SD[i - 1]).norm(), 2.5e-3);
    }
    inside += walk->p_SD[i].norm() < 0.05;
  }
  EXPECT_GT(inside, 2000u);
  EXPECT_LT(inside, 18000u);
}

TEST(TouchTrajectory, RejectsMeshesWithoutArea) {
  EXPECT_FALSE(make_slide_trajectory(TriangleMesh{}, {}).has_value());
  TriangleMesh line;
  line.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  EXPECT_FALSE(make_free_trajectory(line, {}).has_value());
}

}  // namespace
}  // namespace hapton
