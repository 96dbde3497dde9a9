#include "core/tool/held_voxels.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kHeldVoxelM = 0.0005;

// A cube of 20 mm, held in its middle, over a floor whose top is at z = 0.
std::unique_ptr<VoxelTool> cube_over_floor() {
  auto made = VoxelTool::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)),
                              {made::shared(made::box({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}))},
                              {.stiffness_n_per_m = 1000.0, .rotational_stiffness_nm_per_rad = 0.2}, kHeldVoxelM);
  EXPECT_TRUE(made);
  return std::move(*made);
}

ToolInput hand_at(double z) {
  ToolInput input;
  input.X_WD.translation().z() = z;
  return input;
}

TEST(HeldVoxels, BeginsAtTheDeviceAndIsKnownFromTheNextStepOn) {
  HeldVoxels held(cube_over_floor(), {0.01, 0.01, 0.01});
  EXPECT_FALSE(held.is_known());
  const ToolOutput first = held.step(hand_at(0.05), 0);
  EXPECT_FALSE(first.contact);
  EXPECT_FALSE(held.is_known());
  EXPECT_EQ(held.tool().placement().position, Vec3(0.0, 0.0, 0.05)) << "at the device at once, not on the way to it from the origin";
  held.step(hand_at(0.05), 1'000'000);
  EXPECT_TRUE(held.is_known());
  EXPECT_EQ(held.vertex_m(), Vec3(0.01, 0.01, 0.01));
}

// Sample by sample, the force is that of a VoxelTool alone, as `hapton replay` uses it.
TEST(HeldVoxels, GivesTheForceOfTheVoxels) {
  HeldVoxels held(cube_over_floor(), Vec3::Zero());
  const auto alone = cube_over_floor();
  alone->reset(hand_at(0.02));
  for (int n = 0; n < 250; ++n) {
    const ToolInput input = hand_at(0.02 - 5.2e-5 * n);
    const ToolOutput felt = held.step(input, 1'000'000 * n);
    const ToolOutput expected = alone->step(input);
    ASSERT_EQ(felt.force_n, expected.force_n) << n;
    ASSERT_EQ(felt.torque_nm, expected.torque_nm) << n;
    ASSERT_EQ(felt.contact, expected.contact) << n;
  }
  EXPECT_TRUE(held.step(hand_at(0.007), 0).contact);
  EXPECT_EQ(held.push_on(0).force_n, Vec3::Zero());
}

// The tool moves half a voxel, 0.25 mm, in each sample: a hand that is 60 mm ahead may have gone around the floor.
TEST(HeldVoxels, AHandThatIsFarAheadIsNotPulledBackToWhatTheToolMeetsLater) {
  HeldVoxels held(cube_over_floor(), Vec3::Zero());
  held.step(hand_at(0.02), 0);
  held.step(hand_at(-0.04), 1);
  for (int n = 2; n < 400; ++n) EXPECT_EQ(held.step(hand_at(-0.04), n).force_n, Vec3(Vec3::Zero())) << n;
  EXPECT_LT(held.tool().placement().position.z(), -0.03);
  // A tool in contact stays there, however far away the hand is.
  for (int n = 0; n < 400; ++n) held.step(hand_at(-0.04 + 1e-4 * n), n);
  const double below_m = held.tool().placement().position.z();
  EXPECT_LT(below_m, -0.018);
  EXPECT_TRUE(held.step(hand_at(0.01), 0).contact);
  EXPECT_NEAR(held.tool().placement().position.z(), below_m, 2e-3);
}

TEST(HeldVoxels, BeginsAnewWhereTheDeviceIs) {
  HeldVoxels held(cube_over_floor(), Vec3::Zero());
  held.step(hand_at(0.02), 0);
  held.begin_anew();
  held.step(hand_at(0.035), 1);
  EXPECT_EQ(held.tool().placement().position, Vec3(0.0, 0.0, 0.035));
  EXPECT_FALSE(held.is_known());
}

TEST(HeldVoxels, AnInvalidPoseBeginsNothing) {
  HeldVoxels held(cube_over_floor(), Vec3::Zero());
  const ToolOutput felt = held.step(hand_at(std::numeric_limits<double>::quiet_NaN()), 0);
  EXPECT_EQ(felt.force_n, Vec3::Zero());
  held.step(hand_at(0.03), 1);
  EXPECT_FALSE(held.is_known());
  EXPECT_EQ(held.tool().placement().position, Vec3(0.0, 0.0, 0.03));
}

TEST(HeldVoxels, AStepTakesNothingFromTheHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  HeldVoxels held(cube_over_floor(), Vec3::Zero());
  const AllocationGuard guard;
  for (int n = 0; n < 200; ++n) held.step(hand_at(0.02 - 1e-4 * n), n);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
