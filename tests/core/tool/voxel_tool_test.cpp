#include "core/tool/voxel_tool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

std::shared_ptr<const TriangleMesh> shared_mesh(TriangleMesh mesh) { return std::make_shared<const TriangleMesh>(std::move(mesh)); }

constexpr ToolCoupling kSoftCoupling{.stiffness_n_per_m = 1000.0, .rotational_stiffness_nm_per_rad = 0.2};

ToolInput at(const Vec3& p) {
  ToolInput input;
  input.X_WD.translation() = p;
  return input;
}

// A cube of 20 mm pressed 4 mm into a plane: the right force is 4 N. Voxels keep it apart by up to a voxel, and their springs give way.
double error_of_pressing(double voxel_m) {
  auto tool = VoxelTool::make(make_box(Vec3::Constant(0.02), 2), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, voxel_m);
  EXPECT_TRUE(tool);
  (*tool)->reset(at({0.0, 0.0, 0.02}));
  ToolOutput felt;
  // Down at 40 mm/s, then at rest.
  for (int i = 0; i <= 1500; ++i) felt = (*tool)->step(at({0.0, 0.0, std::max(0.006, 0.02 - 4e-5 * i)}));
  EXPECT_TRUE(felt.contact);
  EXPECT_LE(std::hypot(felt.force_n.x(), felt.force_n.y()), 0.05);
  return std::fabs(felt.force_n.z() - 4.0);
}

TEST(VoxelTool, ErrsByLessThanTwoVoxelsAndLessWithSmallerOnes) {
  for (const double voxel_m : {0.002, 0.001, 0.0005, 0.00025}) EXPECT_LE(error_of_pressing(voxel_m), 2.0 * 1000.0 * voxel_m) << voxel_m;
  EXPECT_LT(error_of_pressing(0.00025), 0.5 * error_of_pressing(0.002) + 0.05);
}

TEST(VoxelTool, GivesNoForceInFreeSpaceAndFollowsTheDevice) {
  auto tool = VoxelTool::make(make_icosphere(0.01, 3), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, 0.001);
  ASSERT_TRUE(tool);
  (*tool)->reset(at({0.0, 0.0, 0.05}));
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(0.0001 * i, 0.0, 0.05);
    const ToolOutput felt = (*tool)->step(at(p));
    EXPECT_FALSE(felt.contact);
    EXPECT_EQ(felt.force_n, Vec3::Zero());
    EXPECT_LE(((*tool)->placement().position - p).norm(), 1e-9);
  }
}

// However fast the device goes, no point passes a voxel unseen: a sphere thrown at a wall stays before it.
TEST(VoxelTool, IsNotThrownThroughAWall) {
  auto tool = VoxelTool::make(make_icosphere(0.01, 3), {shared_mesh(make_box({0.2, 0.2, 0.02}, 4))}, kSoftCoupling, 0.001);
  ASSERT_TRUE(tool);
  (*tool)->reset(at({0.0, 0.0, 0.03}));
  ToolOutput felt;
  for (int i = 0; i < 500; ++i) felt = (*tool)->step(at({0.0, 0.0, 0.0}));
  EXPECT_TRUE(felt.contact);
  EXPECT_GT(felt.force_n.z(), 5.0);
  EXPECT_GT((*tool)->placement().position.z(), 0.018);
}

TEST(VoxelTool, AStepTakesNothingFromTheHeap) {
  auto tool = VoxelTool::make(make_icosphere(0.01, 3), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, 0.001);
  ASSERT_TRUE(tool);
  const AllocationGuard guard;
  for (int i = 0; i < 100; ++i) (void)(*tool)->step(at({0.0, 0.0, 0.012 - 0.0001 * i}));
  EXPECT_EQ(guard.count(), 0U);
}

TEST(VoxelTool, WhatIsNoPoseIsNotFollowed) {
  auto tool = VoxelTool::make(make_icosphere(0.01, 3), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, 0.001);
  ASSERT_TRUE(tool);
  (*tool)->reset(at({0.0, 0.0, 0.05}));
  const ToolOutput felt = (*tool)->step(at(Vec3::Constant(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(felt.force_n, Vec3::Zero());
  EXPECT_EQ((*tool)->placement().position, Vec3(0.0, 0.0, 0.05));
  // And far outside the grid nothing is touched.
  EXPECT_FALSE((*tool)->step(at(Vec3::Constant(1e12))).contact);
}

TEST(VoxelTool, ImpossibleSizesAreErrorsThatNameOneThatFits) {
  const auto scene = shared_mesh(make_plane_grid(0.2, 10));
  const auto cube = shared_mesh(make_box(Vec3::Constant(0.2), 2));
  EXPECT_FALSE(VoxelTool::make(make_icosphere(0.01, 2), {scene}, kSoftCoupling, 0.0));
  EXPECT_FALSE(VoxelTool::make(make_icosphere(0.01, 2), {scene}, kSoftCoupling, std::numeric_limits<double>::quiet_NaN()));
  const auto tiny = VoxelTool::make(make_icosphere(0.01, 2), {cube}, kSoftCoupling, 1e-6);
  ASSERT_FALSE(tiny);
  EXPECT_THAT(tiny.error().what, testing::HasSubstr("fits"));
  EXPECT_FALSE(VoxelTool::make(TriangleMesh{}, {scene}, kSoftCoupling, 0.001));
}

}  // namespace
}  // namespace hapton
