// A floor and a wall that programs move hold a probe. Which materials count where both hold it, and when a patch comes later?
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "tests/patch/chain_stage.h"

namespace hapton {
namespace {

constexpr double kCornerStiffness = 1000.0;
constexpr double kFloorDamping = 5.0;
constexpr double kWallDamping = 8.0;
constexpr double kWallX = 0.01;
const Vec3 kAboveFloor(0.002, 0.001, 0.004);
const Vec3 kInFloor(0.002, 0.001, -0.001);
const Vec3 kInCorner(0.011, 0.001, -0.001);  // 1 mm deep in both

TouchScene damped_corner() {
  TouchScene scene;
  scene.objects.push_back(
      {made::shared(made::sheet(0.05, 0.0, 10)), {.stiffness_n_per_m = kCornerStiffness, .damping_ns_per_m = kFloorDamping}});
  scene.objects.push_back({made::shared(made::box(Vec3(kWallX, -0.03, -0.01), Vec3(0.03, 0.03, 0.03))),
                           {.stiffness_n_per_m = kCornerStiffness, .damping_ns_per_m = kWallDamping}});
  scene.objects.back().command_pivot = Vec3(0.02, 0.0, 0.0);
  return on_patch_grid(scene);
}

// Moves the hand straight from `from` to `to`.
ChainStage::Outputs move_hand(ChainStage& stage, const Vec3& from, const Vec3& to, int steps, bool makes_patches = true) {
  ChainStage::Outputs felt;
  for (int n = 1; n <= steps; ++n) {
    felt = stage.step(from + static_cast<double>(n) / static_cast<double>(steps) * (to - from), Pose::Identity(), makes_patches);
  }
  return felt;
}

void move_into_the_corner(ChainStage& stage) {
  (void)move_hand(stage, kAboveFloor, kAboveFloor, 5);
  (void)move_hand(stage, kAboveFloor, kInFloor, 100);
  (void)move_hand(stage, kInFloor, kInCorner, 200);
}

// Each surface has a spring and a damper, along the direction in which it holds the probe.
TEST(PatchCorner, HasTheDampingOfBothSurfaces) {
  ChainStage stage(damped_corner());
  move_into_the_corner(stage);
  constexpr double kSpeed = 0.05;
  Vec3 hand = kInCorner;
  for (int n = 0; n < 20; ++n) {
    hand += kSpeed * ChainStage::kStepS * Vec3(1, 0, -1);
    const ChainStage::Outputs felt = stage.step(hand);
    ASSERT_TRUE(felt.patch.has_value()) << n;
    const Vec3 expected(-kCornerStiffness * (hand.x() - kWallX) - kWallDamping * kSpeed, 0.0,
                        -kCornerStiffness * hand.z() + kFloorDamping * kSpeed);
    EXPECT_LT((felt.patch->force_n - expected).norm(), 1e-3) << n;
    EXPECT_LT((felt.patch->force_n - felt.whole.force_n).norm(), 1e-6) << n;
  }
}

// After `hapton set` with the probe in the corner, both shares have the mean of the new stiffnesses of the surfaces.
TEST(PatchCorner, AnotherMaterialCountsWhereBothSurfacesHoldTheProbe) {
  ChainStage stage(damped_corner());
  move_into_the_corner(stage);
  auto felt = move_hand(stage, kInCorner, kInCorner, 5);
  ASSERT_TRUE(felt.patch.has_value());
  EXPECT_LT((felt.patch->force_n - Vec3(-1.0, 0.0, 1.0)).norm(), 1e-3);
  auto softer = std::make_unique<PatchMaterials>();
  softer->version = 1;
  softer->objects.emplace_back(0, Material{.stiffness_n_per_m = 400.0});
  (void)stage.chain().take(std::move(softer));
  felt = move_hand(stage, kInCorner, kInCorner, 2);
  ASSERT_TRUE(felt.patch.has_value());
  EXPECT_LT((felt.patch->force_n - Vec3(-0.7, 0.0, 0.7)).norm(), 1e-3);
}

// The patch was being made while the material changed, so it comes with the old one.
TEST(PatchCorner, APatchThatComesLaterHasThePresentMaterials) {
  ChainStage stage(on_patch_grid(scene_of(made::sheet(0.05, 0.0, 10), {.stiffness_n_per_m = kCornerStiffness})));
  PatchChain& chain = stage.chain();
  (void)move_hand(stage, kAboveFloor, kAboveFloor, 3, false);
  PatchMaker maker;
  maker.note_hand(chain.hand_of(0, 1));
  auto patch = maker.make_if_due(stage.store(), 0);
  ASSERT_NE(patch, nullptr);
  auto softer = std::make_unique<PatchMaterials>();
  softer->version = 1;
  softer->objects.emplace_back(0, Material{.stiffness_n_per_m = 300.0});
  (void)chain.take(std::move(softer));
  (void)chain.offer(0, std::move(patch));
  const auto felt = move_hand(stage, kAboveFloor, kInFloor, 100, false);
  ASSERT_TRUE(felt.patch.has_value());
  EXPECT_NEAR(felt.patch->force_n.z(), 0.3, 1e-6);
}

}  // namespace
}  // namespace hapton
