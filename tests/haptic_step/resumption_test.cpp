// When a probe continues from its old position after a break, and when it begins anew at the hand.
#include <gtest/gtest.h>

#include <limits>

#include "core/math/contact_resumption.h"
#include "haptic_step/haptics_step.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kSheetStiffness = 1000.0;
constexpr std::int64_t kMillisecondNs = 1'000'000;

TouchScene sheet_scene() { return {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {.stiffness_n_per_m = kSheetStiffness}}}}; }

// A haptics node at a sheet at z = 0, which is felt from both sides.
struct Resumption : testing::Test {
  HapticsStep step{std::make_unique<TouchStep>(*make_method({}, sheet_scene())), 1e-5};
  DeviceState state{.sample = 100, .sample_time_ns = 5'000'000'000};

  const DeviceState& next(double z_m, std::int64_t gap_ns = kMillisecondNs) {
    ++state.sample;
    state.sample_time_ns += gap_ns;
    state.p_WD = Vec3(0.01, 0.01, z_m);
    return state;
  }
  ForceCommand reply(double z_m, std::int64_t gap_ns = kMillisecondNs) {
    step.offer(next(z_m, gap_ns));
    return step.reply();
  }
  void press() {
    reply(0.001);
    ASSERT_TRUE(reply(-0.002).contact);
  }
};

TEST_F(Resumption, AHandFarAwayAfterAGapIsNotPulledBack) {
  for (const std::int64_t gap_ns : {kMillisecondNs, 20 * kMillisecondNs, 2000 * kMillisecondNs}) {
    EXPECT_FALSE(reply(0.03).contact);
    const ForceCommand behind = reply(-0.03, gap_ns);
    EXPECT_FALSE(behind.contact) << gap_ns;
    EXPECT_EQ(behind.force_n, Vec3(Vec3::Zero()));
    step.restart();
  }
}

// On a slow network samples come rarely: a fast hand moves far between two of them.
TEST_F(Resumption, AFastHandDoesNotPassThroughASheet) {
  reply(0.015);
  const ForceCommand through = reply(-0.015, 4 * kMillisecondNs);
  EXPECT_TRUE(through.contact);
  EXPECT_NEAR(through.force_n.z(), kSheetStiffness * 0.015, 1e-3);
}

TEST_F(Resumption, AHandThatIsStillNearKeepsItsContactAcrossAGap) {
  press();
  const ForceCommand after = reply(-0.003, 2000 * kMillisecondNs);
  EXPECT_TRUE(after.contact);
  EXPECT_NEAR(after.force_n.z(), kSheetStiffness * 0.003, 1e-3);
}

// The hand is beyond kResumeReachM. If the probe continued from its old position, the surface in between would hold it.
TEST_F(Resumption, APressedHandThatWentFarBeginsAnew) {
  press();
  EXPECT_FALSE(reply(-0.002 - 1.1 * kResumeReachM, 500 * kMillisecondNs).contact);
}

// The hub computed the force meanwhile. It knows that the hand is free, although this node has not seen the hand leave the sheet.
TEST_F(Resumption, TheHubKnowsThatTheHandIsFree) {
  press();
  DeviceState free = next(-0.002, 50 * kMillisecondNs);
  free.is_resumed = true;
  free.p_WP = free.p_WD;
  step.offer(free);
  EXPECT_FALSE(step.reply().contact);
}

// Since then the hand has moved on from that position, through the sheet.
TEST_F(Resumption, AMotionFromTheFreePositionOfTheHubIsFollowed) {
  reply(0.005);
  DeviceState through = next(-0.002, 50 * kMillisecondNs);
  through.is_resumed = true;
  through.p_WP = Vec3(0.01, 0.01, 0.003);
  step.offer(through);
  const ForceCommand felt = step.reply();
  EXPECT_TRUE(felt.contact);
  EXPECT_NEAR(felt.force_n.z(), kSheetStiffness * 0.002, 1e-3);
}

// While the hub computes the force it sends 20 states a second.
TEST_F(Resumption, BetweenTwoOfFewStatesAHandGoesFar) {
  step.set_thinned(true);
  reply(0.015);
  EXPECT_TRUE(reply(-0.015, 50 * kMillisecondNs).contact);
  step.set_thinned(false);
  step.restart();
  reply(0.015);
  EXPECT_FALSE(reply(-0.015, 50 * kMillisecondNs).contact);
}

// announce_start() has what is near built before the first reply of a session. It must not drop the contact that this reply continues.
TEST_F(Resumption, AnnouncingTheStartTakesNoContactAway) {
  press();
  step.resume();
  step.offer(next(-0.003));
  step.announce_start();
  const ForceCommand first = step.reply();
  EXPECT_TRUE(first.contact);
  EXPECT_NEAR(first.force_n.z(), kSheetStiffness * 0.003, 1e-3);
  EXPECT_EQ(first.replied_before, kUnknownBefore);
}

TEST_F(Resumption, APositionThatIsNotFiniteTakesNoContactAway) {
  press();
  step.offer(next(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_TRUE(step.reply().force_n.allFinite());
  const ForceCommand after = reply(-0.002);
  EXPECT_TRUE(after.contact);
  EXPECT_EQ(after.replied_before & 0b111U, 0b111U) << "no session ended";
}

// The hub requests in each sample to continue from the position of its probe, until a reply comes.
TEST_F(Resumption, SeveralRequestsToContinueAreOneStart) {
  reply(0.005);
  std::uint64_t replied_before = 0;
  for (int n = 0; n < 4; ++n) {
    DeviceState inside = next(-0.002, n == 0 ? 50 * kMillisecondNs : kMillisecondNs);
    inside.is_resumed = true;
    inside.p_WP = Vec3(0.01, 0.01, 0.0);
    step.offer(inside);
    const ForceCommand felt = step.reply();
    EXPECT_TRUE(felt.contact) << n;
    replied_before = felt.replied_before;
  }
  EXPECT_EQ(replied_before, 0b111U) << "each of them had a reply";
}

TEST_F(Resumption, AViewThatMovesNothingLeavesTheContact) {
  press();
  step.resume();
  ASSERT_TRUE(step.turn_scene({.revision = 2}));
  EXPECT_TRUE(reply(-0.003).contact);
}

TEST_F(Resumption, AfterTheSceneWasTurnedTheOldPositionIsNotUsed) {
  ViewTransform lower{.revision = 2};
  lower.X_WS[11] = -0.001F;
  for (const bool turns_first : {false, true}) {
    press();
    if (turns_first) {
      ASSERT_TRUE(step.turn_scene(lower));
    }
    step.resume();
    if (!turns_first) {
      ASSERT_TRUE(step.turn_scene(lower));
    }
    EXPECT_FALSE(reply(-0.0015).contact) << turns_first;
    ASSERT_TRUE(step.turn_scene({.revision = 3}));
    step.restart();
  }
}

// How fast the hand is, and so the force of a viscous volume, is known only in the first step with the new scene.
TEST(EffectsOfANewScene, ComeWithoutAJump) {
  TouchScene scene = sheet_scene();
  scene.effects.push_back(ViscousEffect{.damping_ns_per_m = 1.0, .volume = EffectVolume::ball(Vec3(10, 0, 0), 0.01)});
  HapticsStep step(std::make_unique<TouchStep>(*make_method({}, scene), scene), 1e-5);
  DeviceState state{.sample = 1, .sample_time_ns = 5'000'000'000, .p_WD = Vec3(0, 0, 0.05)};
  const auto reply = [&] {
    ++state.sample;
    state.sample_time_ns += kMillisecondNs;
    state.p_WD.x() += 0.3e-3;
    step.offer(state);
    return step.reply().force_n.norm();
  };
  for (int n = 0; n < 50; ++n) reply();
  scene.effects.push_back(ViscousEffect{.damping_ns_per_m = 50.0, .max_force_n = 8.0});
  step.replace(std::make_unique<TouchStep>(*make_method({}, scene), scene));
  double before_n = reply();
  EXPECT_LE(before_n, 0.02 * 8.0);
  double after_n = before_n;
  for (int n = 0; n < 120; ++n) {
    after_n = reply();
    EXPECT_LE(after_n - before_n, 0.02 * 8.0) << n;
    before_n = after_n;
  }
  EXPECT_GT(after_n, 7.0);
}

// The new scene lacks an effect that pressed harder than the surface pushes: the force of the old method pointed into the surface.
TEST(EffectsOfANewScene, LeaveTheHandOnTheSideOnWhichItWas) {
  const TouchScene plain = sheet_scene();
  TouchScene with_push = plain;
  with_push.effects = {ConstantEffect{.force_n = {0, 0, -5}}};
  HapticsStep step(std::make_unique<TouchStep>(*make_method({.name = "proxy"}, with_push), with_push), 1e-5);
  DeviceState state{.sample = 1, .sample_time_ns = 5'000'000'000};
  const auto reply = [&](double z_m) {
    ++state.sample;
    state.sample_time_ns += kMillisecondNs;
    state.p_WD = Vec3(0.01, 0.01, z_m);
    step.offer(state);
    return step.reply();
  };
  reply(0.001);
  ASSERT_LT(reply(-0.002).force_n.z(), 0.0);
  step.replace(std::make_unique<TouchStep>(*make_method({.name = "proxy"}, plain), plain));
  ForceCommand command;
  for (int i = 0; i < 120; ++i) command = reply(-0.002);
  EXPECT_TRUE(command.contact);
  EXPECT_GT(command.force_n.z(), 1.0) << "out of the surface";
}

}  // namespace
}  // namespace hapton
