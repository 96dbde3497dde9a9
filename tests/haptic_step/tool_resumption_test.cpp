// When a rigid tool continues from its old position after a break, and when it begins anew at the hand.
#include <gtest/gtest.h>

#include "core/math/contact_resumption.h"
#include "haptic_step/haptics_step.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;

// A box of 20 mm, held in its middle, over a sheet at z = 0 that is felt from both sides.
struct ToolResumption : testing::Test {
  TouchScene scene{.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {.stiffness_n_per_m = 1000.0}}}};
  HapticsStep step{std::make_unique<TouchStep>(*make_method({.name = "sweep"}, scene)), 1e-5};
  HeldTool tool{std::move(
      *ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), {scene.objects[0].mesh}, {.stiffness_n_per_m = 1000.0}))};
  DeviceState state{.sample = 100, .sample_time_ns = 5'000'000'000};

  void SetUp() override { step.hold(&tool); }
  ForceCommand reply(double z_m, std::int64_t gap_ns = kTickNs, double turn_rad = 0.0) {
    ++state.sample;
    state.sample_time_ns += gap_ns;
    state.p_WD = Vec3(0.01, 0.01, z_m);
    state.q_WT = turn_by({0.0, 0.0, turn_rad});
    step.offer(state);
    const ForceCommand command = step.reply();
    tool.follow();
    return command;
  }
  // The force once the slow task has found where the tool is.
  double settle_n(double z_m, double turn_rad = 0.0) {
    double force_n = 0.0;
    for (int n = 0; n < 30; ++n) force_n = reply(z_m, kTickNs, turn_rad).force_n.norm();
    return force_n;
  }
  void press() {
    for (double z_m = 0.015; z_m > 0.008; z_m -= 1e-4) reply(z_m);
    ASSERT_NEAR(settle_n(0.008), 2.0, 0.1);
  }
};

TEST_F(ToolResumption, AHandThatWentAroundTheSheetIsNotPulledBack) {
  for (const std::int64_t gap_ns : {kTickNs, 500 * kTickNs}) {
    press();
    reply(-0.03, gap_ns);
    EXPECT_EQ(settle_n(-0.03), 0.0) << gap_ns;
    EXPECT_FALSE(step.is_tool_blocked());
    step.restart();
    EXPECT_EQ(settle_n(0.03), 0.0) << "and back in a new session";
  }
}

TEST_F(ToolResumption, ANewSessionFarAwayBeginsAnew) {
  press();
  step.resume();
  reply(-0.03, 500 * kTickNs);
  EXPECT_EQ(settle_n(-0.03), 0.0);
  EXPECT_EQ(step.free_starts(), 2U);
}

TEST_F(ToolResumption, AHandThatIsStillNearKeepsItsContact) {
  press();
  reply(0.007, 500 * kTickNs);
  EXPECT_NEAR(settle_n(0.007), 3.0, 0.1);
  step.resume();
  reply(0.006, 500 * kTickNs);
  EXPECT_NEAR(settle_n(0.006), 4.0, 0.1);
  EXPECT_EQ(step.free_starts(), 1U);
}

TEST_F(ToolResumption, AHandThatHasTurnedFarMeanwhileBeginsAnew) {
  press();
  for (const double turn_rad : {0.9 * kResumeTurnRad, 1.8 * kResumeTurnRad}) {
    reply(0.008, 500 * kTickNs, turn_rad);
    settle_n(0.008, turn_rad);
  }
  EXPECT_EQ(step.free_starts(), 1U);
  const double far_rad = 3.1 * kResumeTurnRad;
  reply(0.008, 500 * kTickNs, far_rad);
  EXPECT_EQ(settle_n(0.008, far_rad), 0.0);
  EXPECT_TRUE(step.is_tool_blocked()) << "it overlaps the sheet there";
  EXPECT_EQ(settle_n(0.02, far_rad), 0.0);
  EXPECT_FALSE(step.is_tool_blocked());
  EXPECT_EQ(step.free_starts(), 2U);
}

TEST_F(ToolResumption, AFastTurnIsFollowedWhileSamplesComeInTime) {
  press();
  for (int n = 1; n <= 40; ++n) reply(0.008, kTickNs, 0.04 * n);
  EXPECT_NEAR(settle_n(0.008, 1.6), 2.0, 0.1);
  EXPECT_EQ(step.free_starts(), 1U);
}

TEST_F(ToolResumption, WhereTheSceneWasTurnedMeanwhileItBeginsAnew) {
  press();
  step.resume();
  ViewTransform lower{.revision = 2};
  lower.X_WS[11] = -0.001F;
  ASSERT_TRUE(step.turn_scene(lower));
  EXPECT_EQ(settle_n(0.008), 0.0);
  EXPECT_EQ(step.free_starts(), 2U);
}

// A plate with as much damping as surgical training scenes use.
struct DampedResumption : testing::Test {
  std::unique_ptr<TouchStep> make_touch() {
    const TouchScene scene{.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {.stiffness_n_per_m = 1000.0, .damping_ns_per_m = 2.0}}}};
    return std::make_unique<TouchStep>(*make_method({}, scene), scene);
  }
  HapticsStep step{make_touch(), 1e-5};
  DeviceState state{.sample = 100, .sample_time_ns = 5'000'000'000, .p_WD = Vec3(0.01, 0.01, 0.003)};

  double reply_n() {
    ++state.sample;
    state.sample_time_ns += kTickNs;
    step.offer(state);
    return step.reply().force_n.z();
  }
};

// The hand has not moved from the proxy to the device: as a motion of 3 mm in a millisecond, this would give 6 N of damping.
TEST_F(DampedResumption, AContactThatTheHubHandsOverIsNotDampedAsAMotion) {
  for (const bool has_sample_before : {false, true}) {
    if (has_sample_before) {
      state.p_WD.z() = 0.003;
      EXPECT_EQ(reply_n(), 0.0);
    }
    state.p_WD.z() = -0.003;
    state.is_resumed = true;
    state.p_WP = Vec3(0.01, 0.01, 0.0);
    for (int n = 0; n < 3; ++n) EXPECT_NEAR(reply_n(), 3.0, 0.02) << has_sample_before << " " << n;
    state.is_resumed = false;
    step.restart();
  }
}

TEST_F(DampedResumption, AContactOfThisNodeIsNotDampedAsAMotionEither) {
  reply_n();
  state.p_WD.z() = -0.003;
  for (int n = 0; n < 3; ++n) reply_n();
  step.resume();
  for (int n = 0; n < 3; ++n) EXPECT_NEAR(reply_n(), 3.0, 0.02) << n;
}

// Two hubs start one after the other, before the first of them has got a reply.
TEST_F(DampedResumption, ASessionWithoutAReplyTakesNoContactAway) {
  reply_n();
  state.p_WD.z() = -0.003;
  for (int n = 0; n < 3; ++n) reply_n();
  step.resume();
  step.resume();
  EXPECT_NEAR(reply_n(), 3.0, 0.02);
}

}  // namespace
}  // namespace hapton
