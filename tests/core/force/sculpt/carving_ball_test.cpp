#include "core/force/sculpt/carving_ball.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr SculptSettings kBlockSculpt{.voxel_m = 0.001, .tool_radius_m = 0.005, .button = 1};
constexpr double kTopM = 0.02;  // z of the top of the block

struct Block {
  Sculpture sculpture;
  CarvingBall ball{kBlockSculpt};
  Material material = {.stiffness_n_per_m = 500.0};

  Block() { EXPECT_TRUE(sculpture.add(0, kBlockSculpt, make_box(Vec3(0.08, 0.06, 2.0 * kTopM)))); }
  CarvingBall::Felt step(const Vec3& goal, bool is_down, double dt_s = 1e-3) {
    sculpture.begin_step();
    return ball.step({.goal = goal, .dt_s = dt_s, .is_down = is_down}, material, sculpture, 0);
  }
  double top_at(double x, double y) const {
    const CarvedField& field = sculpture.bodies()[0].field;
    double z = 0.03;
    while (z > -0.03 && field.value({x, y, z}) > 0.0) z -= 1e-5;
    return z;
  }
};

TEST(CarvingBall, TouchesALittleInsideTheRadiusThatItCarves) {
  Block block;
  block.ball.reset({0, 0, 0.03});
  EXPECT_FALSE(block.step({0, 0, 0.0251}, false).contact);
  const CarvingBall::Felt felt = block.step({0, 0, 0.022}, false);
  EXPECT_TRUE(felt.contact);
  EXPECT_NEAR(felt.p_SP.z(), kTopM + 0.005 - 0.0007, 0.0002);
  EXPECT_FALSE(block.sculpture.made());
}

// The hand holds still 4 mm deep: the ball sinks in, the force falls as exp(-t / kCutS), and the cut has the shape of the ball.
TEST(CarvingBall, SinksInAsFastAsItIsPressed) {
  Block block;
  block.ball.reset({0, 0, 0.03});
  const Vec3 hand(0, 0, kTopM + 0.001);
  Vec3 proxy = block.step(hand, false).p_SP;
  const double depth = proxy.z() - hand.z();
  for (int i = 1; i <= 200; ++i) {
    const Vec3 next = block.step(hand, true).p_SP;
    ASSERT_LE(next.z(), proxy.z());
    // Each carve is a little larger than what the ball needs.
    ASSERT_NEAR(next.z() - hand.z(), depth * std::exp(-1e-3 * i / CarvingBall::kCutS), 0.25 * kBlockSculpt.voxel_m) << i;
    proxy = next;
  }
  EXPECT_NEAR(block.top_at(0, 0), hand.z() - 0.005, 0.0006);
  EXPECT_NEAR(block.top_at(0.006, 0), kTopM, 1e-4);
  EXPECT_LT(block.sculpture.newest(), 12U) << "one each half a voxel";
  EXPECT_GT(block.sculpture.newest(), 4U);
}

// The hand goes across the block at 0.1 m/s with the button down: the force settles at stiffness times speed times kCutS, and never changes
// faster than the hand and the cut can move.
TEST(CarvingBall, CutsAGrooveWithASteadyForce) {
  Block block;
  block.ball.reset({-0.06, 0, kTopM + 0.001});
  const double speed = 0.1;
  Vec3 last = Vec3::Zero();
  for (int i = 0; i <= 1200; ++i) {
    const Vec3 hand(-0.06 + 1e-3 * speed * i, 0, kTopM + 0.001);
    const Vec3 extension = block.step(hand, true).p_SP - hand;
    ASSERT_LE((extension - last).norm(), 1e-3 * (speed + CarvingBall::kMaxCutSpeed)) << i;
    if (hand.x() > -0.02 && hand.x() < 0.02) {
      EXPECT_NEAR(extension.norm(), speed * CarvingBall::kCutS, 0.2 * speed * CarvingBall::kCutS) << i;
    }
    last = extension;
  }
  EXPECT_TRUE(last.isZero(1e-9)) << "free again, beyond the block";
  for (const double x : {-0.02, 0.0, 0.013}) EXPECT_NEAR(block.top_at(x, 0), kTopM - 0.004, 2e-4);
  // In the groove the ball touches nothing on its way back.
  for (int i = 1200; i >= 0; --i) {
    const Vec3 hand(-0.06 + 1e-3 * speed * i, 0, kTopM + 0.001);
    ASSERT_FALSE(block.step(hand, false).contact) << i;
  }
}

// Past the edge of the block the ball lags behind the hand. The lag fades with both kCutS and kCatchUpS, whatever the length of a step.
TEST(CarvingBall, CatchesUpInFreeSpace) {
  for (const double dt_s : {1e-3, 2e-3}) {
    Block block;
    block.ball.reset({-0.06, 0, kTopM + 0.001});
    const double speed = 0.1;
    double last = 0.0;
    int fading_steps = 0;
    for (double x = -0.06; x < 0.07; x += speed * dt_s) {
      const Vec3 hand(x, 0, kTopM + 0.001);
      const Vec3 proxy = block.step(hand, true, dt_s).p_SP;
      const double lag = hand.x() - proxy.x();
      if (proxy.x() > 0.04 && lag > 1e-6) {
        EXPECT_NEAR(lag / last, std::exp(-dt_s / CarvingBall::kCatchUpS - dt_s / CarvingBall::kCutS), 1e-3) << x;
        ++fading_steps;
      }
      last = lag;
    }
    EXPECT_GT(fading_steps, 20);
  }
}

// The long step follows a gap in the samples, in which the hand went deep into the block.
TEST(CarvingBall, ALongStepCutsNoFartherThanTwoMilliseconds) {
  Block block;
  block.ball.reset({0, 0, 0.03});
  const Vec3 top = block.step({0, 0, kTopM + 0.001}, false).p_SP;
  const Vec3 deep(0, 0, -0.01);
  const double kMaxCutM = CarvingBall::kMaxCutSpeed * 2e-3;
  const double tolerance_m = 0.7 * kBlockSculpt.voxel_m;
  const Vec3 after = block.step(deep, true, 1.0).p_SP;
  EXPECT_LT(top.z() - after.z(), kMaxCutM + tolerance_m);
  EXPECT_GT(top.z() - after.z(), kMaxCutM - 1e-9);
  // A step of half those two milliseconds cuts half as far.
  const Vec3 next = block.step(deep, true, 1e-3).p_SP;
  EXPECT_LT(after.z() - next.z(), 0.5 * kMaxCutM + tolerance_m);
  EXPECT_GT(after.z() - next.z(), 0.5 * kMaxCutM - 1e-9);
}

TEST(CarvingBall, ReleaseOfTheButtonIsContinuous) {
  Block block;
  block.ball.reset({0, 0, 0.03});
  const Vec3 hand(0, 0, kTopM);
  Vec3 last = block.step(hand, true).p_SP;
  for (int i = 1; i < 200; ++i) {
    const Vec3 next = block.step(hand, i < 15).p_SP;
    ASSERT_LE((next - last).norm(), 1e-3 * CarvingBall::kMaxCutSpeed + 1e-9) << i;
    last = next;
  }
  EXPECT_GT(last.z() - hand.z(), 0.001) << "held by what is left";
}

TEST(CarvingBall, FeelsAndCarvesNothingWhileItIsInsideSinceTheStart) {
  Block block;
  block.ball.reset(Vec3::Zero());
  for (int i = 0; i < 50; ++i) {
    EXPECT_FALSE(block.step({0, 0, 0.0004 * i}, true).contact);
    EXPECT_FALSE(block.sculpture.made());
  }
  EXPECT_FALSE(block.step({0, 0, 0.04}, false).contact);
  EXPECT_TRUE(block.step({0, 0, 0.02}, false).contact);
}

// Coulomb friction: a pull within the cone holds the ball where it is; beyond it the ball slides, with the pull of the dynamic cone.
TEST(CarvingBall, HasFriction) {
  Block block;
  block.material.friction_static = 0.5;
  block.material.friction_dynamic = 0.3;
  block.ball.reset({0, 0, 0.03});
  const double depth = 0.002;
  const double height = block.step({0, 0, 0.0}, false).p_SP.z();
  for (int i = 0; i < 20; ++i) block.step({0, 0, height - depth}, false);
  Vec3 proxy = block.step({0.9 * 0.5 * depth, 0, height - depth}, false).p_SP;
  EXPECT_NEAR(proxy.x(), 0.0, 1e-6);
  Vec3 hand;
  for (int i = 0; i <= 300; ++i) {
    hand = Vec3(1e-5 * i * 2.0, 0, height - depth);
    proxy = block.step(hand, false).p_SP;
  }
  EXPECT_NEAR(hand.x() - proxy.x(), 0.3 * depth, 0.03 * depth);
}

}  // namespace
}  // namespace hapton
