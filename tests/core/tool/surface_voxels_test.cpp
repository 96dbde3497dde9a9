#include "core/tool/surface_voxels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "core/collision/triangle_box.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using Key = std::array<int, 3>;

std::set<Key> keys_of(const std::vector<SurfaceVoxel>& voxels) {
  std::set<Key> keys;
  for (const SurfaceVoxel& voxel : voxels) keys.insert({voxel.cell.x(), voxel.cell.y(), voxel.cell.z()});
  return keys;
}

// The brute-force twin: random sample points on the triangles lie in voxels that are found, and the middle of each voxel that is found is
// at most half a diagonal away from some triangle.
TEST(SurfaceVoxels, HoldEachPointOfTheSurfaceAndNothingFarther) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const double voxel_m : {0.03, 0.007}) {
    const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.2, 300, 5);
    const VoxelGrid grid{Vec3(0.01, -0.02, 0.003), voxel_m};
    const auto found = find_surface_voxels(mesh, grid);
    ASSERT_TRUE(found);
    const std::set<Key> keys = keys_of(*found);
    EXPECT_EQ(keys.size(), found->size()) << "each once";
    std::vector<Vec3> samples;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int n = 0; n < 200; ++n) {
        double u = uniform(random);
        double v = uniform(random);
        if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
        const Vec3 p = mesh.corner(t, 0) + u * (mesh.corner(t, 1) - mesh.corner(t, 0)) + v * (mesh.corner(t, 2) - mesh.corner(t, 0));
        samples.push_back(p);
        const Vec3 cell = ((p - grid.origin_m) / voxel_m).array().floor();
        ASSERT_TRUE(keys.contains({static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())}))
            << p.transpose() << ", seed 11";
      }
    }
    for (const SurfaceVoxel& found_voxel : *found) {
      const Vec3 middle = grid.centre_m(found_voxel.cell);
      double nearest = 1.0;
      for (const Vec3& p : samples) nearest = std::min(nearest, (p - middle).norm());
      // The samples lie less than a tenth of a voxel's diagonal apart.
      EXPECT_LE(nearest, (0.5 * std::sqrt(3.0) + 0.2) * voxel_m) << found_voxel.cell.transpose();
    }
  }
}

TriangleMesh triangle_of(const Vec3& a, const Vec3& b, const Vec3& c) { return {{a, b, c}, {{0, 1, 2}}}; }

// The search skips ranges of cells that a triangle does not touch, but no cell that it touches.
TEST(SurfaceVoxels, AreThoseThatATestOfEveryCellFinds) {
  constexpr unsigned kSeed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(-20.0, 20.0);
  const auto draw = [&] { return Vec3(place(random), place(random), place(random)); };
  for (int n = 0; n < 20; ++n) {
    const std::array<Vec3, 3> corner = {draw(), draw(), draw()};
    const auto found = find_surface_voxels(triangle_of(corner[0], corner[1], corner[2]), {Vec3::Zero(), 1.0});
    ASSERT_TRUE(found);
    std::set<Key> expected;
    for (int z = -21; z <= 20; ++z) {
      for (int y = -21; y <= 20; ++y) {
        for (int x = -21; x <= 20; ++x) {
          const Vec3 low(x, y, z);
          if (may_touch(corner, low, low + Vec3::Ones())) expected.insert({x, y, z});
        }
      }
    }
    EXPECT_EQ(keys_of(*found), expected) << "triangle " << n;
    EXPECT_EQ(found->size(), expected.size()) << "each once";
  }
}

// The bounding box of this triangle has more than 10^13 cells: a search of all of them would take days.
TEST(SurfaceVoxels, ALongTriangleCostsOnlyTheCellsThatItTouches) {
  const Vec3 end(3e4, 2.7e4, 2.4e4);
  const auto found = find_surface_voxels(triangle_of(Vec3::Zero(), end, end + Vec3(0.0, 0.0, 0.5)), {Vec3::Zero(), 1.0});
  ASSERT_TRUE(found);
  EXPECT_GT(found->size(), 60'000U);
  EXPECT_LT(found->size(), 600'000U);
}

TEST(SurfaceVoxels, NormalsPointOutwards) {
  const auto found = find_surface_voxels(make_icosphere(0.04, 4), {Vec3::Zero(), 0.005});
  ASSERT_TRUE(found);
  for (const SurfaceVoxel& voxel : *found) {
    EXPECT_NEAR(voxel.normal.norm(), 1.0, 1e-12);
    EXPECT_GT(voxel.normal.dot(VoxelGrid{Vec3::Zero(), 0.005}.centre_m(voxel.cell).normalized()), 0.9);
  }
}

// A wall between two layers of voxels belongs to both.
TEST(SurfaceVoxels, WhatTouchesASideBelongsToBothCells) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0.25, 0.25, 1.0), Vec3(0.75, 0.25, 1.0), Vec3(0.25, 0.75, 1.0)};
  mesh.triangles = {{0, 1, 2}};
  const auto found = find_surface_voxels(mesh, {Vec3::Zero(), 1.0});
  ASSERT_TRUE(found);
  EXPECT_EQ(keys_of(*found), (std::set<Key>{{0, 0, 0}, {0, 0, 1}}));
}

TEST(SurfaceVoxels, ASizeThatDoesNotFitIsAnErrorThatNamesOne) {
  const TriangleMesh mesh = make_icosphere(0.05, 2);
  const auto tiny = find_surface_voxels(mesh, {Vec3::Zero(), 1e-9});
  ASSERT_FALSE(tiny);
  EXPECT_THAT(tiny.error().what, testing::HasSubstr("fits"));
  TriangleMesh from_origin;
  from_origin.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  from_origin.triangles = {{0, 1, 2}};
  const auto at_one_end = find_surface_voxels(from_origin, {Vec3::Zero(), 1e-9});
  ASSERT_FALSE(at_one_end);
  EXPECT_THAT(at_one_end.error().what, testing::HasSubstr("fits"));
  const auto too_many = find_surface_voxels(mesh, {Vec3::Zero(), 0.001}, 100);
  ASSERT_FALSE(too_many);
  EXPECT_THAT(too_many.error().what, testing::HasSubstr("larger"));
}

}  // namespace
}  // namespace hapton
