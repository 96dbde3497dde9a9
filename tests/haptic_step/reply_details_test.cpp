// What a reply and the counters report in addition to the force of the probe or the tool.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/math/rotation_vector.h"
#include "core/tool/held_tool.h"
#include "haptic_step/haptics_step.h"
#include "scene/tool_obstacles.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kDetailOffset = 1e-5;

TouchScene detail_sheet() { return {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {.stiffness_n_per_m = 1000.0}}}}; }
std::unique_ptr<TouchStep> detail_touch(const TouchScene& scene) { return std::make_unique<TouchStep>(*make_method({}, scene), scene); }

struct ReplyDetails : testing::Test {
  HapticsStep step{detail_touch(detail_sheet()), kDetailOffset};
  DeviceState state{.sample = 100, .sample_time_ns = 5'000'000'000};

  ForceCommand reply(HapticsStep& from, const Vec3& p_WD, const Quat& q_WT = Quat::Identity(), std::int64_t after_ns = 1'000'000) {
    ++state.sample;
    state.sample_time_ns += after_ns;
    state.p_WD = p_WD;
    state.q_WT = q_WT;
    from.offer(state);
    return from.reply();
  }
};

// InsideBodyWarning checks only the places where the probe started without an earlier contact.
TEST_F(ReplyDetails, AFreeStartIsOneWithoutAContactThatGoesOn) {
  reply(step, {0.01, 0.01, 0.001});
  EXPECT_EQ(step.free_starts(), 1U);
  ASSERT_TRUE(reply(step, {0.01, 0.01, -0.002}).contact);
  step.resume();
  ASSERT_TRUE(reply(step, {0.01, 0.01, -0.002}).contact);
  EXPECT_EQ(step.free_starts(), 1U) << "the contact goes on";
  step.restart();
  EXPECT_FALSE(reply(step, {0.01, 0.01, -0.002}).contact);
  EXPECT_EQ(step.free_starts(), 2U);
}

TEST_F(ReplyDetails, WhatTouchesIsTheDevicePointInTheFrameOfTheScene) {
  ASSERT_TRUE(step.turn_scene({.revision = 1, .X_WS = {0, -1, 0, 0.02F, 1, 0, 0, 0, 0, 0, 1, 0}}));
  reply(step, {0.03, 0.01, 0.005});
  EXPECT_LT((step.p_STouching() - Vec3(0.01, -0.01, 0.005)).norm(), 1e-8) << step.p_STouching().transpose();
}

TEST_F(ReplyDetails, TheLargestForceIsCounted) {
  for (const double z : {0.001, -0.001, -0.003, -0.002}) reply(step, {0.01, 0.01, z});
  EXPECT_NEAR(step.counts().max_force_n, 3.0, 1e-3);
  EXPECT_EQ(step.counts().max_torque_nm, 0.0);
}

// This happens when a device repeats a sample, or its clock is set back.
TEST_F(ReplyDetails, ASampleThatIsNoLaterThanTheOneBeforeCountsAsAMillisecond) {
  TouchScene scene = detail_sheet();
  scene.effects = {WaveEffect{.waveform = Waveform::sine, .amplitude_n = 1.0, .frequency_hz = 20.0}};
  HapticsStep waves(detail_touch(scene), kDetailOffset);
  int n = 0;
  for (const std::int64_t after_ns : {1'000'000, 0, 0, -5'000'000, 0, 1'000'000}) {
    const ForceCommand felt = reply(waves, {0.01, 0.01, 0.01}, Quat::Identity(), after_ns);
    EXPECT_NEAR(felt.force_n.z(), std::sin(2.0 * std::numbers::pi * 20.0 * 1e-3 * ++n), 1e-9) << n;
  }
}

// A box of 2 cm, held askew and pressed onto the sheet.
TEST_F(ReplyDetails, PairsOfTrianglesAndTheTorqueOfAToolAreCounted) {
  EXPECT_FALSE(reply(step, {0.01, 0.01, 0.03}).haptons) << "a probe";
  HeldTool tool(std::move(*ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), {detail_sheet().objects[0].mesh},
                                          {.stiffness_n_per_m = 1000.0})));
  HapticsStep tool_step(detail_touch(detail_sheet()), kDetailOffset);
  tool_step.hold(&tool);
  std::uint64_t haptons = 0;
  std::uint32_t most_haptons = 0;
  double largest_torque_nm = 0.0;
  for (int n = 0; n < 100; ++n) {
    const ForceCommand felt = reply(tool_step, {0.01, 0.01, 0.014 - 1e-4 * std::min(n, 60)}, turn_by({0.1, 0.0, 0.0}));
    tool.follow();
    ASSERT_TRUE(felt.haptons) << n;
    if (n == 0) {
      EXPECT_EQ(*felt.haptons, 0U) << "in the air";
    }
    haptons += *felt.haptons;
    most_haptons = std::max(most_haptons, *felt.haptons);
    largest_torque_nm = std::max(largest_torque_nm, felt.torque_nm.norm());
  }
  EXPECT_GT(haptons, 20U);
  EXPECT_EQ(tool_step.counts().haptons, haptons);
  EXPECT_EQ(tool_step.counts().most_haptons, static_cast<int>(most_haptons));
  EXPECT_GT(largest_torque_nm, 1e-3);
  EXPECT_EQ(tool_step.counts().max_torque_nm, largest_torque_nm);
}

// One object comes from below and one from the side. The one that presses harder is the object in contact, first in the scene or not.
TEST_F(ReplyDetails, OfTwoObjectsOfProgramsTheReplyNamesTheOneThatIsPressedMost) {
  for (const bool is_first : {true, false}) {
    TouchScene scene;
    scene.objects.push_back({made::shared(made::sheet(0.1, -0.2, 6)), {.stiffness_n_per_m = 1000.0}});
    scene.objects.push_back({made::shared(made::box(Vec3::Constant(-0.02), Vec3::Constant(0.02))), {}});
    scene.objects.push_back({made::shared(made::box(Vec3(0.03, -0.02, 0.042), Vec3(0.05, 0.02, 0.09))), {}});
    for (const std::size_t object : {1U, 2U}) scene.objects[object].command_pivot = Vec3::Zero();
    HapticsStep tool_step(detail_touch(scene), kDetailOffset);
    ToolObstacles obstacles = make_tool_obstacles(scene);
    HeldTool tool(std::move(*ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), obstacles.meshes,
                                            {.stiffness_n_per_m = 1000.0}, obstacles.friction, nullptr, obstacles.part_of)));
    tool_step.hold(&tool, obstacles.parts);
    const auto move = [&](int object, const Vec3& to) {
      const Keyframe from{0.0, Vec3::Zero(), Quat::Identity()};
      return tool_step.command(object, {.serial = 1, .from = from, .to = {0.2, to, Quat::Identity()}});
    };
    // One object goes 5 mm, the other 2 mm into the tool where the hand holds it.
    ASSERT_TRUE(move(1, {0.0, 0.0, is_first ? 0.020 : 0.017}));
    ASSERT_TRUE(move(2, {is_first ? -0.022 : -0.025, 0.0, 0.0}));
    ForceCommand felt;
    for (int n = 0; n < 300; ++n) {
      felt = reply(tool_step, {0.0, 0.0, 0.045});
      tool.follow();
    }
    EXPECT_EQ(felt.object, is_first ? 1 : 2);
    ASSERT_TRUE(felt.push);
    const Vec3 expected_push_n = is_first ? Vec3(0.0, 0.0, -5.0) : Vec3(5.0, 0.0, 0.0);
    EXPECT_LT((felt.push->force_n - expected_push_n).norm(), 0.02) << felt.push->force_n.transpose();
  }
}

}  // namespace
}  // namespace hapton
