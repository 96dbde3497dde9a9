#include "core/tool/voxel_tool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

std::shared_ptr<const TriangleMesh> shared_mesh(TriangleMesh mesh) { return std::make_shared<const TriangleMesh>(std::move(mesh)); }

constexpr ToolCoupling kSoftCoupling{.stiffness_n_per_m = 1000.0, .rotational_stiffness_nm_per_rad = 0.2};

ToolInput device_at(const Vec3& p) {
  ToolInput input;
  input.X_WD.translation() = p;
  return input;
}

// Presses a cube of 20 mm 4 mm into a plane; the right force is 4 N. Voxels keep the cube up to a voxel away, and their springs yield.
double press_force_error_n(double voxel_m) {
  auto tool = VoxelTool::make(make_box(Vec3::Constant(0.02), 2), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, voxel_m);
  EXPECT_TRUE(tool);
  (*tool)->reset(device_at({0.0, 0.0, 0.02}));
  ToolOutput felt;
  // Down at 40 mm/s, then at rest.
  for (int i = 0; i <= 1500; ++i) felt = (*tool)->step(device_at({0.0, 0.0, std::max(0.006, 0.02 - 4e-5 * i)}));
  EXPECT_TRUE(felt.contact);
  EXPECT_LE(std::hypot(felt.force_n.x(), felt.force_n.y()), 0.05);
  return std::fabs(felt.force_n.z() - 4.0);
}

TEST(VoxelTool, ErrsByLessThanTwoVoxelsAndLessWithSmallerOnes) {
  for (const double voxel_m : {0.002, 0.001, 0.0005, 0.00025}) EXPECT_LE(press_force_error_n(voxel_m), 2.0 * 1000.0 * voxel_m) << voxel_m;
  EXPECT_LT(press_force_error_n(0.00025), 0.5 * press_force_error_n(0.002) + 0.05);
}

TEST(VoxelTool, GivesNoForceInFreeSpaceAndFollowsTheDevice) {
  auto tool = VoxelTool::make(make_icosphere(0.01, 3), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, 0.001);
  ASSERT_TRUE(tool);
  (*tool)->reset(device_at({0.0, 0.0, 0.05}));
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(0.0001 * i, 0.0, 0.05);
    const ToolOutput felt = (*tool)->step(device_at(p));
    EXPECT_FALSE(felt.contact);
    EXPECT_EQ(felt.force_n, Vec3::Zero());
    EXPECT_LE(((*tool)->placement().position - p).norm(), 1e-9);
  }
}

// A bar is held at one end, and its other end is pressed onto a block.
ToolOutput press_far_end(const Pose& X_WS) {
  const TriangleMesh bar = scaled_and_moved(make_box({0.04, 0.01, 0.01}, 4), 1.0, {0.02, 0.0, 0.0});
  const TriangleMesh block = scaled_and_moved(make_box({0.02, 0.04, 0.02}, 4), 1.0, {0.04, 0.0, -0.01});
  auto tool = VoxelTool::make(bar, {shared_mesh(block)}, {.stiffness_n_per_m = 1000.0, .rotational_stiffness_nm_per_rad = 2.0}, 0.001);
  EXPECT_TRUE(tool);
  const auto press_at = [&](double z_m) {
    ToolInput input = device_at({0.00037, 0.00041, z_m});
    input.X_WS = X_WS;
    input.X_WD = X_WS * input.X_WD;
    return input;
  };
  (*tool)->reset(press_at(0.02));
  ToolOutput felt;
  for (int n = 0; n <= 600; ++n) felt = (*tool)->step(press_at(std::max(0.00213, 0.02 - 4e-5 * n)));
  return felt;
}

TEST(VoxelTool, WhatPressesOnItsFarEndTurnsItAwayFromThere) {
  const ToolOutput felt = press_far_end(Pose::Identity());
  ASSERT_TRUE(felt.contact);
  EXPECT_GT(felt.force_n.z(), 0.5);
  EXPECT_NEAR(-felt.torque_nm.y() / felt.force_n.z(), 0.035, 0.01) << "the lever of the block's force";
  EXPECT_GT(felt.X_WP.translation().z(), 0.00213);
  EXPECT_GT((felt.X_WP * Vec3(0.04, 0.0, 0.0)).z(), felt.X_WP.translation().z());
}

TEST(VoxelTool, FeelsTheSameInASceneThatIsMovedAndTurned) {
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(2.0, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  X_WS.translation() = Vec3(0.1, -0.2, 0.3);
  const ToolOutput still = press_far_end(Pose::Identity());
  const ToolOutput turned = press_far_end(X_WS);
  ASSERT_TRUE(turned.contact);
  EXPECT_LT((turned.force_n - X_WS.linear() * still.force_n).norm(), 0.02 * still.force_n.norm());
  EXPECT_LT((turned.torque_nm - X_WS.linear() * still.torque_nm).norm(), 0.02 * still.torque_nm.norm());
  const Pose X_WP = X_WS * still.X_WP;
  EXPECT_LT((turned.X_WP.translation() - X_WP.translation()).norm(), 1e-4);
  EXPECT_LT((turned.X_WP.linear() - X_WP.linear()).norm(), 1e-2);
}

// However fast the device moves, no point passes through a voxel unnoticed: a sphere that is thrown at a wall stays in front of it.
TEST(VoxelTool, IsNotThrownThroughAWall) {
  auto tool = VoxelTool::make(make_icosphere(0.01, 3), {shared_mesh(make_box({0.2, 0.2, 0.02}, 4))}, kSoftCoupling, 0.001);
  ASSERT_TRUE(tool);
  (*tool)->reset(device_at({0.0, 0.0, 0.03}));
  ToolOutput felt;
  for (int i = 0; i < 500; ++i) felt = (*tool)->step(device_at({0.0, 0.0, 0.0}));
  EXPECT_TRUE(felt.contact);
  EXPECT_GT(felt.force_n.z(), 5.0);
  EXPECT_GT((*tool)->placement().position.z(), 0.018);
}

// Brute-force twin: counts the points of the tool's shell that lie in a voxel of the scene, beyond the plane through the voxel's middle.
int count_contacts(const TriangleMesh& tool, const std::vector<std::shared_ptr<const TriangleMesh>>& scene, double voxel_m,
                   const Pose& X_SD) {
  Vec3 low = scene.front()->vertices.front();
  for (const auto& mesh : scene) {
    for (const Vec3& vertex : mesh->vertices) low = low.cwiseMin(vertex);
  }
  const VoxelGrid grid{low - Vec3::Constant(voxel_m), voxel_m};
  std::set<std::array<int, 3>> cells;
  for (const auto& mesh : scene) {
    const auto voxels = find_surface_voxels(*mesh, grid);
    for (const SurfaceVoxel& voxel : *voxels) cells.insert({voxel.cell.x(), voxel.cell.y(), voxel.cell.z()});
  }
  const VoxelGrid tool_grid{Vec3::Zero(), voxel_m};
  const auto shell = find_surface_voxels(tool, tool_grid);
  int count = 0;
  for (const SurfaceVoxel& voxel : *shell) {
    const Vec3 p = X_SD * tool_grid.centre_m(voxel.cell);
    const Eigen::Vector3i cell = ((p - grid.origin_m) / voxel_m).array().floor().cast<int>();
    const double outward_m = (grid.centre_m(cell) - p).dot(X_SD.linear() * voxel.normal);
    count += outward_m < 0.0 && cells.contains({cell.x(), cell.y(), cell.z()}) ? 1 : 0;
  }
  return count;
}

// Two boxes with different side lengths in opposite corners of a grid that is mostly empty.
TEST(VoxelTool, FindsTheContactsThatBruteForceFinds) {
  constexpr double kVoxelM = 0.0013;
  const TriangleMesh tool = make_icosphere(0.006, 2);
  const std::vector<std::shared_ptr<const TriangleMesh>> scene = {
      shared_mesh(make_box({0.013, 0.009, 0.011}, 1)),
      shared_mesh(scaled_and_moved(make_box({0.011, 0.013, 0.007}, 1), 1.0, {0.043, 0.031, 0.037}))};
  auto made = VoxelTool::make(tool, scene, kSoftCoupling, kVoxelM);
  ASSERT_TRUE(made);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> share(-0.2, 1.2);
  int touching_poses = 0;
  for (int n = 0; n < 600; ++n) {
    const Vec3 corner = n % 3 == 0 ? Vec3::Zero() : Vec3(0.043, 0.031, 0.037);
    const Vec3 shares(share(random), share(random), share(random));
    ToolInput input;
    input.X_WD.linear() = Eigen::AngleAxisd(6.0 * share(random), Vec3(share(random), 1.0, share(random)).normalized()).toRotationMatrix();
    input.X_WD.translation() = n % 3 == 2 ? Vec3(0.043 * shares.x(), 0.031 * shares.y(), 0.037 * shares.z())
                                          : Vec3(corner + 0.02 * (shares - Vec3::Constant(0.5)));
    (*made)->reset(input);
    const ToolOutput felt = (*made)->step(input);
    const int expected = count_contacts(tool, scene, kVoxelM, input.X_WD);
    ASSERT_EQ(felt.proxy.haptons, expected) << n;
    ASSERT_EQ(felt.contact, expected > 0) << n;
    touching_poses += expected > 0 ? 1 : 0;
  }
  EXPECT_GT(touching_poses, 100);
  EXPECT_LT(touching_poses, 500);
}

TEST(VoxelTool, TheRotationalStiffnessScalesWithTheStiffness) {
  auto tool = VoxelTool::make(make_icosphere(0.01, 2), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, 0.002);
  ASSERT_TRUE(tool);
  EXPECT_EQ((*tool)->coupling().rotational_stiffness_nm_per_rad, 0.2);
  (*tool)->set_stiffness(500.0);
  EXPECT_EQ((*tool)->coupling().stiffness_n_per_m, 500.0);
  EXPECT_NEAR((*tool)->coupling().rotational_stiffness_nm_per_rad, 0.1, 1e-12);
}

// A bar is held at one end, and the device turns by 90 degrees in one step: the limit applies to the far end, whichever end is held.
TEST(VoxelTool, NoPointMovesFartherThanHalfAVoxelAStepHoweverItIsTurned) {
  constexpr double kVoxelM = 0.001;
  constexpr double kLengthM = 0.04;
  for (const double middle_m : {-0.5 * kLengthM, 0.5 * kLengthM}) {
    const TriangleMesh bar = scaled_and_moved(make_box({0.004, 0.004, kLengthM}, 1), 1.0, {0.0, 0.0, middle_m});
    auto tool = VoxelTool::make(bar, {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, kVoxelM);
    ASSERT_TRUE(tool);
    ToolInput input = device_at({0.0, 0.0, 0.1});
    (*tool)->reset(input);
    input.X_WD.linear() = Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitX()).toRotationMatrix();
    const Vec3 far_end(0.0, 0.0, 2.0 * middle_m);
    const auto far_point = [&] { return Vec3((*tool)->placement().position + (*tool)->placement().orientation * far_end); };
    double farthest_m = 0.0;
    for (int i = 0; i < 200; ++i) {
      const Vec3 before = far_point();
      (void)(*tool)->step(input);
      farthest_m = std::max(farthest_m, (far_point() - before).norm());
    }
    EXPECT_LE(farthest_m, 0.55 * kVoxelM) << "the end lies up to half a voxel beyond the last point";
    EXPECT_GT(farthest_m, 0.45 * kVoxelM) << "no more slowly than the limit allows";
    EXPECT_LE((far_point() - input.X_WD * far_end).norm(), 1e-6) << "it reaches the device's pose";
  }
}

TEST(VoxelTool, AStepTakesNothingFromTheHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  auto tool = VoxelTool::make(make_icosphere(0.01, 3), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, 0.001);
  ASSERT_TRUE(tool);
  (*tool)->reset(device_at({0.0, 0.0, 0.02}));
  ToolOutput felt;
  const AllocationGuard guard;
  for (int i = 0; i < 100; ++i) felt = (*tool)->step(device_at({0.0, 0.0, 0.012 - 0.0001 * i}));
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_TRUE(felt.contact);
}

TEST(VoxelTool, AnInvalidPoseIsNotFollowed) {
  auto tool = VoxelTool::make(make_icosphere(0.01, 3), {shared_mesh(make_plane_grid(0.2, 10))}, kSoftCoupling, 0.001);
  ASSERT_TRUE(tool);
  (*tool)->reset(device_at({0.0, 0.0, 0.05}));
  const ToolOutput felt = (*tool)->step(device_at(Vec3::Constant(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(felt.force_n, Vec3::Zero());
  EXPECT_EQ((*tool)->placement().position, Vec3(0.0, 0.0, 0.05));
  // Far outside the grid the tool touches nothing.
  EXPECT_FALSE((*tool)->step(device_at(Vec3::Constant(1e12))).contact);
}

TEST(VoxelTool, ImpossibleSizesAreErrorsThatNameOneThatFits) {
  const auto scene = shared_mesh(make_plane_grid(0.2, 10));
  const auto cube = shared_mesh(make_box(Vec3::Constant(0.2), 2));
  for (const double size_m : {0.0, -0.001, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    const auto made = VoxelTool::make(make_icosphere(0.01, 2), {scene}, kSoftCoupling, size_m);
    ASSERT_FALSE(made) << size_m;
    EXPECT_THAT(made.error().what, testing::HasSubstr("give a positive size")) << size_m;
  }
  const auto tiny = VoxelTool::make(make_icosphere(0.01, 2), {cube}, kSoftCoupling, 1e-6);
  ASSERT_FALSE(tiny);
  // 2^30 cells are a cube of 1024 cells a side: 0.195 mm each for 0.2 m. The error names a twentieth more.
  EXPECT_THAT(tiny.error().what, testing::EndsWith("; 0.000205 m fits"));
  // The normals of the sheet's two sides cancel in every voxel.
  const TriangleMesh sheet = joined(make_plane_grid(0.02, 2), flipped(make_plane_grid(0.02, 2)));
  const auto flat = VoxelTool::make(sheet, {scene}, kSoftCoupling, 0.001);
  ASSERT_FALSE(flat);
  EXPECT_THAT(flat.error().what, testing::HasSubstr("no points"));
  const auto nothing = VoxelTool::make(TriangleMesh{}, {scene}, kSoftCoupling, 0.001);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().what, ToolStep::make(TriangleMesh{}, {scene}, kSoftCoupling).error().what);
  const auto far = VoxelTool::make(scaled_and_moved(make_icosphere(0.01, 2), 1.0, {3000.0, 0.0, 0.0}), {scene}, kSoftCoupling, 0.001);
  ASSERT_FALSE(far);
  EXPECT_THAT(far.error().what, testing::HasSubstr("voxel"));
}

}  // namespace
}  // namespace hapton
