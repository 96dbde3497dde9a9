// A rigid tool and parts of the scene that move.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/held_tool.h"
#include "core/tool/penetration_check.h"
#include "core/tool/tool_step.h"
#include "tests/core/tool/random_vector.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kCouplingStiffness = 1000.0;              // N/m, of the coupling
const TriangleMesh kSlab = make_box({0.2, 0.2, 0.02}, 3);  // its top is at 10 mm
const TriangleMesh kCube = make_box({0.02, 0.02, 0.02}, 2);

Pose moved_by(const Vec3& p, const Vec3& turn = Vec3::Zero()) {
  Pose X = Pose::Identity();
  X.translation() = p;
  X.linear() = turn_by(turn).toRotationMatrix();
  return X;
}

std::unique_ptr<ToolStep> make_moving_step(const TriangleMesh& tool, const std::vector<TriangleMesh>& scene, const std::vector<int>& parts,
                                           const CoulombFriction& friction = {}) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (const TriangleMesh& mesh : scene) meshes.push_back(std::make_shared<TriangleMesh>(mesh));
  std::vector<CoulombFriction> all(scene.size(), friction);
  auto made = ToolStep::make(tool, std::move(meshes), {.stiffness_n_per_m = kCouplingStiffness}, std::move(all), nullptr, parts);
  EXPECT_TRUE(made) << made.error().what;
  return std::move(*made);
}

// Checks the tool against each part, at the pose at which the tool feels the part: for penetration by exact signs, and for the distance.
class MovingCheck {
 public:
  explicit MovingCheck(const ToolStep& step) : step_(step) {
    checks_.push_back(std::make_unique<PenetrationCheck>(step.tool(), step.scene()));
    for (std::size_t p = 0; p < step.moving_count(); ++p) {
      checks_.push_back(std::make_unique<PenetrationCheck>(step.tool(), step.moving(p)));
    }
  }
  bool penetrates() {
    for (std::size_t p = 0; p < checks_.size(); ++p) {
      if (checks_[p]->penetrates(placement_in_part(p))) return true;
    }
    return false;
  }
  // The smallest distance, in contact offsets, at most 4.
  double gap() {
    double least = 4.0;
    for (std::size_t p = 0; p < checks_.size(); ++p) {
      least = std::min(least, checks_[p]->find_gap(placement_in_part(p), 4.0 * ToolProxy::kContactOffset) / ToolProxy::kContactOffset);
    }
    return least;
  }

 private:
  Placement placement_in_part(std::size_t p) const {
    const Placement& tool = step_.proxy().placement();
    return p == 0 ? tool : step_.proxy().part_placement(p - 1).inverse() * tool;
  }

  const ToolStep& step_;
  std::vector<std::unique_ptr<PenetrationCheck>> checks_;
};

TEST(ToolAndMotion, ASlabThatRisesPushesTheToolAheadAndIsFelt) {
  const auto step = make_moving_step(kCube, {kSlab}, {1});
  MovingCheck check(*step);
  const Pose hand = moved_by({0.003, 0.004, 0.025});  // 5 mm above the slab
  step->reset({.X_WD = hand});
  double before_n = 0.0;
  ToolOutput out;
  for (int n = 0; n <= 400; ++n) {
    const double rise = 2.5e-5 * n;
    const Pose X_SO = moved_by({0.0, 0.0, rise});
    out = step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
    ASSERT_FALSE(out.proxy.is_squeezed);
    ASSERT_FALSE(check.penetrates()) << n;
    ASSERT_GE(check.gap(), 0.5) << n;
    ASSERT_NEAR(out.force_n.z(), kCouplingStiffness * std::max(0.0, rise - 0.005), 2e-3) << n;
    ASSERT_LE(std::abs(out.force_n.z() - before_n), kCouplingStiffness * 2.6e-5) << "no jump";
    before_n = out.force_n.z();
  }
  EXPECT_TRUE(out.contact);
  EXPECT_EQ(step->proxy().contacts().front().part, 1);
  EXPECT_NEAR(out.torque_nm.norm(), 0.0, 2e-5);
  EXPECT_NEAR(out.X_WP.translation().z(), 0.030, 2e-6);
}

// When the slab sinks, the tool stays on it.
TEST(ToolAndMotion, ASlabThatSinksIsFollowed) {
  const auto step = make_moving_step(kCube, {kSlab}, {1});
  Pose hand = moved_by({0.003, 0.004, 0.025});
  Pose X_SO = Pose::Identity();
  step->reset({.X_WD = hand});
  for (int n = 1; n <= 100; ++n) {
    hand.translation().z() = 0.025 - 1e-4 * n;  // 5 mm deep at the end
    step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
  }
  for (int n = 1; n <= 100; ++n) {
    X_SO.translation().z() = -2.5e-5 * n;
    const ToolOutput out = step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
    ASSERT_NEAR(out.force_n.z(), kCouplingStiffness * (0.005 - 2.5e-5 * n), 2e-3) << n;
  }
}

// For the same relative motion, forces and torques in the frame of the part are the same, whether or not the part moves too.
TEST(ToolAndMotion, OnlyTheMotionOfOnePastTheOtherCounts) {
  const TriangleMesh bumps = make_bumpy_sphere(0.05, 0.1, 1200, 3);
  const auto still = make_moving_step(kCube, {bumps}, {});
  const auto moving = make_moving_step(kCube, {bumps}, {1});
  MovingCheck check(*moving);
  int touching_steps = 0;
  int compared_steps = 0;
  for (int n = 0; n < 1200; ++n) {
    const double t = 1e-3 * n;
    const Pose X_OD = moved_by({0.01 * std::sin(3.0 * t), 0.008 * std::sin(4.0 * t), 0.08 - 0.025 * std::min(t, 0.8)},
                               {0.2 * std::sin(2.0 * t), 0.3 * std::sin(3.0 * t), 0.5 * t});
    const Pose X_SO = moved_by({0.02 * std::sin(2.0 * t), 0.01 * t, 0.01 * std::sin(5.0 * t)}, {0.3 * t, 0.2 * std::sin(4.0 * t), 0.4 * t});
    const ToolInput input_at_rest{.X_WD = X_OD};
    const ToolInput moving_input{.X_WD = X_SO * X_OD, .X_SO = {&X_SO, 1}};
    if (n == 0) {
      still->reset(input_at_rest);
      moving->reset(moving_input);
    }
    const ToolOutput expected = still->step(input_at_rest);
    const ToolOutput out = moving->step(moving_input);
    ASSERT_FALSE(out.proxy.is_squeezed);
    ASSERT_FALSE(check.penetrates()) << n;
    ASSERT_GE(check.gap(), 0.5) << n;
    touching_steps += expected.contact ? 1 : 0;
    if (!expected.proxy.converged || !out.proxy.converged) continue;
    ++compared_steps;
    const Mat3 R_OS = X_SO.linear().transpose();
    ASSERT_LT((R_OS * out.force_n - expected.force_n).norm(), 2e-3 + 2e-3 * expected.force_n.norm()) << n;
    ASSERT_LT((R_OS * out.torque_nm - expected.torque_nm).norm(), 2e-5 + 3e-3 * expected.torque_nm.norm()) << n;
  }
  EXPECT_GT(touching_steps, 400);
  EXPECT_GT(compared_steps, 1100);
}

// Between a moving part and one at rest there is no room for the tool: the part stays behind, and the force does not depend on its target.
TEST(ToolAndMotion, ASqueezedToolKeepsThePartBackUntilThereIsRoom) {
  const TriangleMesh ceiling = scaled_and_moved(kSlab, 1.0, {0.0, 0.0, 0.05});  // its bottom is at 40 mm
  const auto step = make_moving_step(kCube, {ceiling, kSlab}, {0, 1});
  MovingCheck check(*step);
  const Pose hand = moved_by({0.0, 0.0, 0.025}, {0.0, 0.0, 0.1});
  step->reset({.X_WD = hand});
  int squeezed_steps = 0;
  Vec3 before_n = Vec3::Zero();
  Vec3 before_nm = Vec3::Zero();
  for (int n = 0; n <= 1200; ++n) {
    // No room is left when the slab has risen by 10 mm; it goes on to 15 mm, and back down.
    const Pose X_SO = moved_by({0.0, 0.0, 0.015 - 0.015 * std::abs(1.0 - n / 600.0)});
    const ToolOutput out = step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
    ASSERT_FALSE(out.proxy.is_blocked) << n;
    ASSERT_FALSE(check.penetrates()) << n;
    ASSERT_GE(check.gap(), 0.5) << n;
    ASSERT_LE((out.force_n - before_n).norm(), kCouplingStiffness * 6e-5) << n;
    ASSERT_LE((out.torque_nm - before_nm).norm(), kCouplingStiffness * 1e-6) << n;
    ASSERT_EQ(out.proxy.is_squeezed, X_SO.translation().z() > 0.010 - 1.5e-6) << n << " at " << X_SO.translation().z();
    squeezed_steps += out.proxy.is_squeezed ? 1 : 0;
    before_n = out.force_n;
    before_nm = out.torque_nm;
  }
  EXPECT_NEAR(squeezed_steps, 400, 3);
  EXPECT_EQ(before_n, Vec3(Vec3::Zero()));
}

// The part must not jump where the tool is no longer in its way.
TEST(ToolAndMotion, APartThatWasKeptBackCatchesUpAtABoundedSpeed) {
  const TriangleMesh ceiling = scaled_and_moved(kSlab, 1.0, {0.0, 0.0, 0.05});
  const auto step = make_moving_step(kCube, {ceiling, kSlab}, {0, 1});
  Pose hand = moved_by({0.0, 0.0, 0.025});
  Pose X_SO = Pose::Identity();
  step->reset({.X_WD = hand});
  ToolOutput out;
  for (int n = 1; n <= 600; ++n) {
    X_SO = moved_by({0.0, 0.0, 2.5e-5 * n});  // 5 mm farther than there is room
    out = step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
  }
  ASSERT_TRUE(out.proxy.is_squeezed);
  const auto height = [&] { return step->proxy().part_placement(0).position.z(); };
  constexpr double kMaxCatchUp = ToolProxy::kCatchUp * ToolProxy::kContactOffset;
  const double start_height = height();
  hand = moved_by({0.25, 0.0, 0.025});
  int steps = 0;
  for (double last_height = start_height; out.proxy.is_squeezed && steps < 1000; ++steps) {
    out = step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
    ASSERT_LE(height() - last_height, kMaxCatchUp * (1.0 + 1e-9)) << steps;
    last_height = height();
  }
  EXPECT_FALSE(out.proxy.is_squeezed);
  EXPECT_NEAR(steps, (height() - start_height) / kMaxCatchUp, 2.0) << "no more slowly than it may";
}

TEST(ToolAndMotion, APartThatIsKeptBackKeepsNoOtherBack) {
  const TriangleMesh ceiling = scaled_and_moved(kSlab, 1.0, {0.0, 0.0, 0.05});
  const TriangleMesh wall = make_box({0.02, 0.2, 0.01}, 2);
  const auto step = make_moving_step(kCube, {ceiling, kSlab, scaled_and_moved(wall, 1.0, {-0.08, 0.0, 0.03})}, {0, 1, 2});
  MovingCheck check(*step);
  const Pose hand = moved_by({0.0, 0.0, 0.025});
  step->reset({.X_WD = hand});
  ToolOutput out;
  for (int n = 0; n <= 600; ++n) {
    const Pose X_SO[2] = {moved_by({0.0, 0.0, 2.5e-5 * n}), moved_by({1.5e-4 * n, 0.0, 0.0})};
    out = step->step({.X_WD = hand, .X_SO = X_SO});
    ASSERT_FALSE(check.penetrates()) << n;
  }
  EXPECT_TRUE(out.proxy.is_squeezed);
  // The wall ends at -80 + 90 + 10 = 20 mm, and has pushed the cube to 30 mm.
  EXPECT_NEAR(out.X_WP.translation().x(), 0.030, 2e-6);
}

// Two bodies tumble at random around a pressed tool, in some walks faster than a scene file allows; a slab stands still.
TEST(ToolAndMotion, NeverPenetratesWhateverMoves) {
  constexpr unsigned kSeed = 21;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  const auto draw = [&] { return draw_in_cube(random); };
  const TriangleMesh bumps = make_bumpy_sphere(0.03, 0.2, 500, 5);
  const TriangleMesh wedge = make_prism({{0.0, 0.0}, {0.06, -0.004}, {0.06, 0.004}}, 0.05, 2);
  const auto step = make_moving_step(
      kCube, {scaled_and_moved(bumps, 1.0, {0.05, 0.0, 0.0}), scaled_and_moved(wedge, 1.0, {-0.1, 0.0, 0.0}), kSlab}, {1, 2, 0});
  MovingCheck check(*step);
  int touching_steps = 0;
  int squeezed_steps = 0;
  int unconverged_steps = 0;
  for (int walk = 0; walk < 8; ++walk) {
    const double speed = std::pow(10.0, -4.5 + 2.0 * walk / 7.0);  // m per step
    Pose hand = moved_by({0.0, 0.0, 0.06}, draw());
    Pose X_SO[2] = {moved_by({0.05, 0.0, 0.06}), moved_by({-0.05, 0.0, 0.08})};
    step->reset({.X_WD = hand, .X_SO = X_SO});
    ASSERT_FALSE(check.penetrates());
    for (int n = 0; n < 300; ++n) {
      hand.translation() += speed * (draw() + 0.3 * (Vec3(0.0, 0.0, 0.02) - hand.translation()) / 0.05);
      hand.linear() = turn_by(20.0 * speed * draw()).toRotationMatrix() * hand.linear();
      for (Pose& X : X_SO) {
        const Vec3 home = &X == X_SO ? Vec3(-0.04, 0.0, 0.03) : Vec3(0.08, 0.0, 0.03);
        X.translation() += speed * (draw() + (home - X.translation()) / 0.05);
        X.linear() = Quat(turn_by(10.0 * speed * draw()).toRotationMatrix() * X.linear()).normalized().toRotationMatrix();
      }
      const ToolOutput out = step->step({.X_WD = hand, .X_SO = X_SO});
      ASSERT_TRUE(out.force_n.allFinite() && out.torque_nm.allFinite());
      touching_steps += out.contact ? 1 : 0;
      squeezed_steps += out.proxy.is_squeezed ? 1 : 0;
      unconverged_steps += out.proxy.converged ? 0 : 1;
      if (out.proxy.is_blocked) continue;
      ASSERT_FALSE(check.penetrates()) << "walk " << walk << " step " << n;
      ASSERT_GE(check.gap(), 0.49) << "walk " << walk << " step " << n;
    }
  }
  EXPECT_GT(touching_steps, 1000);
  EXPECT_GT(squeezed_steps, 0);
  EXPECT_LT(unconverged_steps, touching_steps / 4);
}

TEST(ToolAndMotion, AToolThatSticksIsCarriedAlong) {
  constexpr CoulombFriction kSlabFriction = {0.5, 0.3};
  const auto step = make_moving_step(kCube, {kSlab}, {1}, kSlabFriction);
  step->reset({.X_WD = moved_by({0.0, 0.0, 0.03})});
  ToolOutput out;
  // At a depth of 2 mm, 2 N press the tool: static friction holds up to 1 N, which stretches the spring by 1 mm.
  for (int n = 0; n <= 120; ++n) out = step->step({.X_WD = moved_by({0.0, 0.0, 0.03 - 1e-4 * n})});
  double largest_n = 0.0;
  for (int n = 0; n <= 300; ++n) {
    const double x = 1e-5 * n;
    const Pose X_SO = moved_by({x, 0.0, 0.0});
    out = step->step({.X_WD = moved_by({0.0, 0.0, 0.018}), .X_SO = {&X_SO, 1}});
    if (x < 0.9e-3) {
      ASSERT_NEAR(out.force_n.x(), kCouplingStiffness * x, 5e-3) << n;
    }
    largest_n = std::max(largest_n, out.force_n.x());
  }
  EXPECT_NEAR(largest_n, kSlabFriction.friction_static * 2.0, 0.02);
  EXPECT_NEAR(out.force_n.x(), kSlabFriction.friction_dynamic * 2.0, 0.02);
  EXPECT_NEAR(out.force_n.z(), 2.0, 5e-3);
}

// The friction belongs to the normal force of the same sample: when the slab rises or sinks within one step, the friction changes in that
// same step.
TEST(ToolAndMotion, FrictionFollowsASlabThatRisesInTheSameStep) {
  const CoulombFriction friction = {0.5, 0.3};
  const auto step = make_moving_step(kCube, {kSlab}, {1}, friction);
  Pose hand = moved_by({-0.03, 0.004, 0.025});
  Pose X_SO = Pose::Identity();
  step->reset({.X_WD = hand});
  for (int n = 1; n <= 60; ++n) {
    hand.translation().z() = 0.025 - 1e-4 * n;  // 1 mm deep at the end
    step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
  }
  ToolOutput out;
  for (int n = 0; n < 60; ++n) {
    hand.translation().x() += 1e-4;
    out = step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
  }
  ASSERT_NEAR(out.force_n.z(), kCouplingStiffness * 0.001, 2e-3);
  ASSERT_NEAR(out.force_n.x(), -friction.friction_dynamic * kCouplingStiffness * 0.001, 5e-3);
  for (const double rise : {0.0005, -0.0005}) {
    X_SO.translation().z() += rise;
    hand.translation().x() += 1e-3;
    out = step->step({.X_WD = hand, .X_SO = {&X_SO, 1}});
    const double expected = kCouplingStiffness * (0.001 + X_SO.translation().z());
    EXPECT_NEAR(out.force_n.z(), expected, 2e-3) << rise;
    EXPECT_NEAR(out.force_n.x(), -friction.friction_dynamic * expected, 5e-3) << rise;
  }
}

TEST(ToolAndMotion, AHeldToolFeelsAPartThatMovesWithoutADiscontinuity) {
  HeldTool held(make_moving_step(kCube, {kSlab}, {1}));
  const Pose hand = moved_by({0.0, 0.0, 0.025});
  double before_n = 0.0;
  double largest_n = 0.0;
  for (int n = 0; n <= 400; ++n) {
    const double rise = 0.010 - 0.010 * std::abs(1.0 - n / 200.0);
    const Pose X_SO = moved_by({0.0, 0.0, rise});
    const ToolOutput out = held.step({.X_WD = hand, .X_SO = {&X_SO, 1}}, 1'000'000 * n);
    if (n % 5 == 0) held.follow();  // the slow task; between two of its steps the contacts move with the part
    if (n > 120 && n < 280) {
      ASSERT_NEAR(out.force_n.z(), kCouplingStiffness * (rise - 0.005), 5e-3) << n;
    }
    // A new contact is felt when the slow task has found it.
    ASSERT_LE(std::abs(out.force_n.z() - before_n), kCouplingStiffness * 5e-5 * (n < 120 ? 6.0 : 1.1) + 1e-3) << n;
    before_n = out.force_n.z();
    largest_n = std::max(largest_n, before_n);
  }
  EXPECT_NEAR(largest_n, kCouplingStiffness * 0.005, 0.01);
}

TEST(ToolAndMotion, AHeldToolPushesNothingWhereAPositionIsNotFinite) {
  HeldTool held(make_moving_step(kCube, {kSlab}, {1}));
  ToolInput input{.X_WD = moved_by({0.0, 0.0, 0.025})};
  Pose X_SO = Pose::Identity();
  input.X_SO = {&X_SO, 1};
  int n = 0;
  for (; n <= 200; ++n) {
    X_SO = moved_by({0.0, 0.0, 5e-5 * n});
    held.step(input, 1'000'000 * n);
    held.follow();
  }
  ASSERT_LT(held.push_on(0).force_n.z(), -4.0);
  input.X_WD.translation().x() = std::numeric_limits<double>::quiet_NaN();
  const ToolOutput out = held.step(input, 1'000'000 * n);
  EXPECT_EQ(out.force_n, Vec3(Vec3::Zero()));
  EXPECT_EQ(held.push_on(0).force_n, Vec3(Vec3::Zero()));
  EXPECT_EQ(held.push_on(0).torque_nm, Vec3(Vec3::Zero()));
}

// A cube slides down a wall with friction, onto a slab without. The wall carries a part of what presses the cube down, so the slab gets
// less than without friction.
TEST(ToolAndMotion, AHeldToolPushesEachPartWithTheForcesOfItsOwnContacts) {
  constexpr double kFriction = 0.5;
  constexpr double kPressN = kCouplingStiffness * 0.002;  // of the hand, into the wall and into the slab
  TriangleMesh wall = make_box({0.02, 0.2, 0.1}, 3);
  for (Vec3& vertex : wall.vertices) vertex += Vec3(0.03, 0.0, 0.065);
  std::vector<std::shared_ptr<const TriangleMesh>> meshes = {std::make_shared<TriangleMesh>(wall), std::make_shared<TriangleMesh>(kSlab)};
  auto made =
      ToolStep::make(kCube, std::move(meshes), {.stiffness_n_per_m = kCouplingStiffness}, {{kFriction, kFriction}, {}}, nullptr, {0, 1});
  ASSERT_TRUE(made) << made.error().what;
  HeldTool held(std::move(*made));
  const Pose X_SO = Pose::Identity();
  ToolOutput out;
  for (int n = 0; n <= 240; ++n) {
    const Vec3 hand(1e-4 * std::min(n, 120), 0.0, 0.025 - 1e-4 * std::clamp(n - 130, 0, 70));
    out = held.step({.X_WD = moved_by(hand), .X_SO = {&X_SO, 1}}, 1'000'000 * n);
    held.follow();
  }
  ASSERT_NEAR(out.force_n.x(), -kPressN, 0.02);
  ASSERT_NEAR(out.force_n.z(), kPressN, 0.02);
  const ToolPush& slab = held.push_on(0);
  EXPECT_NEAR(slab.force_n.z(), -(kPressN - kFriction * kPressN), 0.02);
  EXPECT_LT(slab.force_n.head<2>().norm(), 1e-3);
}

// A tool whose contacts are late is drawn near the place where they were found, but its force acts where the hand is.
TEST(ToolAndMotion, AToolWithLateContactsPushesAPartAboutItsDrawnGripPoint) {
  HeldTool held(make_moving_step(kCube, {kSlab}, {1}));
  const Pose X_SO = Pose::Identity();
  std::int64_t time_ns = 0;
  ToolOutput out;
  for (int n = 0; n <= 120; ++n) {
    out = held.step({.X_WD = moved_by({0.0, 0.0, 0.03 - 1e-4 * n}), .X_SO = {&X_SO, 1}}, time_ns += 1'000'000);
    held.follow();
  }
  ASSERT_NEAR(out.force_n.z(), 2.0, 0.01);
  Vec3 hand = Vec3::Zero();
  for (int n = 1; n <= 12; ++n) {
    hand = Vec3(0.0025 * n, 0.0, 0.018);
    out = held.step({.X_WD = moved_by(hand), .X_SO = {&X_SO, 1}}, time_ns += 1'000'000);
  }
  const ToolPush& push = held.push_on(0);
  ASSERT_NEAR(push.force_n.z(), -2.0, 0.02);
  ASSERT_GT(hand.x() - out.X_WP.translation().x(), 0.02);
  const Vec3 about_origin_nm = out.X_WP.translation().cross(push.force_n) + push.torque_nm;
  EXPECT_LT((about_origin_nm - hand.cross(push.force_n)).norm(), 1e-3);
}

TEST(ToolAndMotion, TooManyMovingPartsAreAnErrorInOneLine) {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes(ToolStep::kMaxParts + 1, std::make_shared<TriangleMesh>(kSlab));
  std::vector<int> parts;
  for (std::size_t n = 0; n < meshes.size(); ++n) parts.push_back(static_cast<int>(n) + 1);
  const auto made = ToolStep::make(kCube, std::move(meshes), {}, {}, nullptr, parts);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().what,
            "33 parts of the scene move by themselves; a rigid tool touches 32 at most: let some stand still, or move together");
}

TEST(ToolAndMotion, TheDescriptionCountsWhatMovesWithTheRest) {
  const std::string text = make_moving_step(kCube, {kSlab, kCube, kSlab, kCube}, {0, 1, 1, 2})->describe();
  const std::size_t triangles = 2 * kSlab.triangles.size() + 2 * kCube.triangles.size();
  EXPECT_NE(text.find("tool: " + std::to_string(kCube.triangles.size()) + " triangles, "), std::string::npos) << text;
  EXPECT_NE(text.find("scene: " + std::to_string(triangles) + " triangles in 4 objects\n"), std::string::npos) << text;
  EXPECT_NE(text.find("objects that move by themselves: 3, in parts: 2\n"), std::string::npos) << text;
  const std::string still = make_moving_step(kCube, {kSlab, kCube}, {})->describe();
  EXPECT_EQ(still.find("move by themselves"), std::string::npos) << still;
}

TEST(ToolAndMotion, UsesNoHeap) {
  const auto step = make_moving_step(kCube, {make_bumpy_sphere(0.05, 0.1, 2000, 1)}, {1}, {0.3, 0.2});
  HeldTool held(make_moving_step(kCube, {make_bumpy_sphere(0.05, 0.1, 2000, 1)}, {1}, {0.3, 0.2}));
  const Pose hand = moved_by({0.0, 0.0, 0.065});
  std::uint64_t count = 0;
  for (int n = 0; n < 300; ++n) {
    const Pose X_SO = moved_by({0.0, 0.0, 5e-5 * n}, {0.0, 0.01 * n, 0.0});
    const ToolInput input{.X_WD = hand, .X_SO = {&X_SO, 1}};
    const AllocationGuard guard;
    step->step(input);
    held.step(input, 1'000'000 * n);
    held.follow();
    count += guard.count();
  }
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  EXPECT_EQ(count, 0U);
}

}  // namespace
}  // namespace hapton
