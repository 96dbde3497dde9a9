#include "haptic_step/haptics_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/contact_resumption.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kOffset = 0.0005 * 0.0254;  // contact offset: half a thousandth of an inch

std::unique_ptr<TouchStep> make_touch(double stiffness = 1000.0) {
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {.stiffness_n_per_m = stiffness}}}};
  return std::make_unique<TouchStep>(*make_method({.name = "sweep"}, scene));
}

// Device states one after the other, a millisecond apart.
class States {
 public:
  DeviceState at(const Vec3& p_WD) {
    ++sample_;
    return {.sample = sample_, .sample_time_ns = 5'000'000'000 + 1'000'000 * static_cast<std::int64_t>(sample_), .p_WD = p_WD};
  }

 private:
  std::uint64_t sample_ = 100;
};

ForceCommand reply_to(HapticsStep& step, const DeviceState& state) {
  step.offer(state);
  return step.reply();
}

TEST(HapticsStep, RepliesWithForceOffsetAndEcho) {
  HapticsStep step(make_touch(), kOffset);
  States states;
  EXPECT_FALSE(step.has_state());
  EXPECT_FALSE(reply_to(step, states.at({0.01, 0.01, 0.001})).contact);
  const DeviceState pressed = states.at({0.01, 0.01, -0.002});
  const ForceCommand command = reply_to(step, pressed);
  EXPECT_EQ(command.echo_sample, pressed.sample);
  EXPECT_EQ(command.echo_sample_time_ns, pressed.sample_time_ns);
  EXPECT_TRUE(command.contact);
  EXPECT_EQ(command.object, 0);
  EXPECT_NEAR((command.force_n - Vec3(0, 0, 2)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((command.visual_offset_m - Vec3(0, 0, 0.002)).norm(), 0.0, 1e-12);
  EXPECT_FALSE(step.has_state());
  EXPECT_EQ(step.counts().replied, 2U);
  EXPECT_EQ(step.counts().contact_steps, 1U);
}

TEST(HapticsStep, ContinuesTheContactOfAnotherNode) {
  States states;
  DeviceState inside = states.at({0.01, 0.01, -0.002});
  HapticsStep without_report(make_touch(), kOffset);
  EXPECT_FALSE(reply_to(without_report, inside).contact) << "it begins below the sheet";

  inside.is_resumed = true;
  inside.p_WP = Vec3(0.01, 0.01, 0.0);
  HapticsStep with_report(make_touch(), kOffset);
  const ForceCommand output = reply_to(with_report, inside);
  EXPECT_TRUE(output.contact);
  EXPECT_NEAR((output.force_n - Vec3(0, 0, 2)).norm(), 0.0, 1e-3);

  // Since the report the hand has moved too far.
  inside.p_WD.z() = -1.1 * kResumeReachM;
  HapticsStep with_old_report(make_touch(), kOffset);
  EXPECT_FALSE(reply_to(with_old_report, inside).contact);
}

TEST(HapticsStep, KeepsContactInANewSessionUnlessReset) {
  for (const bool restarts : {false, true}) {
    HapticsStep step(make_touch(), kOffset);
    States states;
    reply_to(step, states.at({0.01, 0.01, 0.001}));
    ASSERT_TRUE(reply_to(step, states.at({0.01, 0.01, -0.002})).contact);
    restarts ? step.restart() : step.resume();
    const ForceCommand first = reply_to(step, states.at({0.01, 0.011, -0.003}));
    EXPECT_EQ(first.contact, !restarts);
    // A recording of the new session alone cannot tell which samples had a reply before it.
    EXPECT_EQ(first.replied_before, restarts ? 0 : kUnknownBefore);
  }
}

// A hub that has restarted reports an older position of the probe than this node has.
TEST(HapticsStep, KeepsContactWhereTheHubKnowsNone) {
  HapticsStep step(make_touch(), kOffset);
  States states;
  reply_to(step, states.at({0.01, 0.01, 0.001}));
  ASSERT_TRUE(reply_to(step, states.at({0.01, 0.01, -0.002})).contact);
  step.resume();
  DeviceState state = states.at({0.01, 0.011, -0.003});
  state.is_resumed = true;
  state.p_WP = Vec3(0.01, 0.011, -0.0029);
  const ForceCommand first = reply_to(step, state);
  EXPECT_TRUE(first.contact);
  EXPECT_NEAR(first.force_n.z(), 3.0, 1e-2);
  EXPECT_EQ(first.replied_before, kUnknownBefore) << "a recording of the new session alone cannot know it";
}

// If the contact continued here, it would hold the hand back as if it had come from the other side of the sheet.
TEST(HapticsStep, ANewSessionFindsAHandFreeThatHasLeftTheSurface) {
  for (const double z_m : {0.0001, 0.001, 0.01}) {
    HapticsStep step(make_touch(), kOffset);
    States states;
    reply_to(step, states.at({0.01, 0.01, 0.001}));
    ASSERT_TRUE(reply_to(step, states.at({0.01, 0.01, -0.002})).contact);
    step.resume();
    const ForceCommand first = reply_to(step, states.at({0.01, 0.011, z_m}));
    EXPECT_FALSE(first.contact) << z_m;
    EXPECT_EQ(first.replied_before, 0U);
    // The hand feels the sheet again when it comes back to it.
    EXPECT_NEAR(reply_to(step, states.at({0.01, 0.011, -0.001})).force_n.z(), 1.0, 1e-6);
  }
}

TEST(HapticsStep, AnnouncingTheStartBuildsWhatIsNearAndChangesNothingElse) {
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}};
  auto touch = std::make_unique<TouchStep>(*make_method({.name = "proxy", .build_on_approach = true}, scene));
  const auto method = touch->share_method();
  HapticsStep step(std::move(touch), kOffset);
  DeviceState inside{.sample = 1, .sample_time_ns = 1, .p_WD = {0.01, 0.01, -0.002}};
  inside.is_resumed = true;
  inside.p_WP = {0.01, 0.01, 0.0};
  step.offer(inside);
  EXPECT_FALSE(method->prepare());
  step.announce_start();
  EXPECT_TRUE(method->prepare());
  EXPECT_FALSE(method->prepare());
  EXPECT_FALSE(step.is_running());
  EXPECT_TRUE(step.has_state());
  const ForceCommand command = step.reply();
  EXPECT_TRUE(command.contact);  // on the side of the earlier contact
  EXPECT_GT(command.force_n.z(), 0.0);
  EXPECT_EQ(command.replied_before, 0U);
}

TEST(HapticsStep, OnlyTheNewestStateGetsAReplyAndTheOthersAreCounted) {
  HapticsStep step(make_touch(), kOffset);
  States states;
  reply_to(step, states.at({0, 0.001, 0.001}));
  step.offer(states.at({0, 0.001, 0.002}));
  step.offer(states.at({0, 0.001, 0.003}));
  const DeviceState newest = states.at({0, 0.001, 0.004});
  step.offer(newest);
  const ForceCommand command = step.reply();
  EXPECT_EQ(command.echo_sample, newest.sample);
  EXPECT_EQ(command.skipped_samples, 2U);
  EXPECT_EQ(reply_to(step, states.at({0, 0, 0.005})).skipped_samples, 0U);
}

TEST(HapticsStep, AReplySaysWhichOfThe64SamplesBeforeItHadAReply) {
  HapticsStep step(make_touch(), kOffset);
  const auto reply_to_sample = [&](std::uint64_t sample) {
    return reply_to(step, {.sample = sample, .sample_time_ns = static_cast<std::int64_t>(sample), .p_WD = {0, 0, 0.01}}).replied_before;
  };
  EXPECT_EQ(reply_to_sample(100), 0U);
  EXPECT_EQ(reply_to_sample(101), 0b1U);
  EXPECT_EQ(reply_to_sample(102), 0b11U);
  EXPECT_EQ(reply_to_sample(105), 0b11100U);
  EXPECT_EQ(reply_to_sample(164), 1ULL << 63 | 1ULL << 62 | 1ULL << 61 | 1ULL << 58);
  EXPECT_EQ(reply_to_sample(228), 1ULL << 63);
  EXPECT_EQ(reply_to_sample(400), 0U);
  step.restart();
  EXPECT_EQ(reply_to_sample(401), 0U);
}

TEST(HapticsStep, AReplyNamesItsViewAndItsMethod) {
  HapticsStep step(make_touch(), kOffset);
  States states;
  EXPECT_EQ(reply_to(step, states.at({0, 0, 0.01})).view_revision, 0U);
  ASSERT_TRUE(step.turn_scene({.revision = 7}));
  step.replace(make_touch());
  const ForceCommand command = reply_to(step, states.at({0, 0, 0.01}));
  EXPECT_EQ(command.view_revision, 7U);
  EXPECT_EQ(command.method_serial, 1U);
}

TEST(HapticsStep, TheFirstStateIsFreeSpaceWhereverItIs) {
  HapticsStep step(make_touch(), kOffset);
  States states;
  EXPECT_FALSE(reply_to(step, states.at({0, 0.001, -0.002})).contact);
  EXPECT_TRUE(reply_to(step, states.at({0, 0.001, 0.002})).contact);  // from below
  step.restart();
  EXPECT_FALSE(reply_to(step, states.at({0, 0.001, -0.002})).contact);
}

TEST(HapticsStep, ATurnedSceneChangesTheForceAndAnInvalidOneIsIgnored) {
  HapticsStep step(make_touch(), kOffset);
  States states;
  reply_to(step, states.at({0.01, 0.001, 0.001}));
  ViewTransform raised;
  raised.X_WS[11] = 0.003F;  // z of the translation
  EXPECT_TRUE(step.turn_scene(raised));
  const ForceCommand command = reply_to(step, states.at({0.01, 0.001, 0.001}));
  EXPECT_NEAR(command.force_n[2], 2.0, 1e-6);
  ViewTransform scaled = raised;
  scaled.X_WS[0] = 2.0F;
  EXPECT_FALSE(step.turn_scene(scaled));
  EXPECT_NEAR(reply_to(step, states.at({0.01, 0.001, 0.001})).force_n[2], 2.0, 1e-6);
  EXPECT_EQ(step.counts().views_applied, 1U);
  EXPECT_EQ(step.counts().views_rejected, 1U);
}

TEST(HapticsStep, AMethodTakesOverInContactWithoutAForceDiscontinuity) {
  for (const double side : {1.0, -1.0}) {
    HapticsStep step(make_touch(1000.0), kOffset);
    States states;
    ViewTransform moved;
    moved.X_WS[3] = 0.02F;
    step.turn_scene(moved);
    reply_to(step, states.at({0.01, 0.01, side * 0.001}));
    ASSERT_NEAR(reply_to(step, states.at({0.01, 0.01, -side * 0.002})).force_n[2], side * 2.0, 1e-9);
    EXPECT_NE(step.replace(make_touch(1100.0)), nullptr);
    for (int i = 1; i <= 100; ++i) {
      const double felt_n = reply_to(step, states.at({0.01, 0.01, -side * 0.002})).force_n[2];
      EXPECT_NEAR(felt_n, side * (2.0 + 0.002 * i), 1e-9) << "the difference of 0.2 N fades in a tenth of a second";
    }
    EXPECT_NEAR(reply_to(step, states.at({0.01, 0.01, -side * 0.002})).force_n[2], side * 2.2, 1e-9);
  }
}

// For example, an object is removed from the scene while the hand presses it.
TEST(HapticsStep, TheForceFadesWhereTheNextMethodHasNoSurface) {
  const TouchScene elsewhere = {.objects = {{made::shared(made::sheet(0.1, -0.05, 6)), {}}}};
  HapticsStep step(make_touch(), kOffset);
  States states;
  reply_to(step, states.at({0.01, 0.01, 0.001}));
  ASSERT_NEAR(reply_to(step, states.at({0.01, 0.01, -0.002})).force_n.z(), 2.0, 1e-9);
  step.replace(std::make_unique<TouchStep>(*make_method({.name = "sweep"}, elsewhere)));
  for (int i = 1; i <= 12; ++i) {
    const double remaining_n = 2.0 * std::max(0.0, 1.0 - 1e-3 * i / ForceFade::kInAirS);
    EXPECT_NEAR(reply_to(step, states.at({0.01, 0.01, -0.002})).force_n.z(), remaining_n, 1e-9) << i;
  }
}

// An effect may push into the surface harder than the surface pushes out: the new method still starts outside.
TEST(HapticsStep, AMethodTakesOverOnTheSameSideWithEffects) {
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}, .effects = {ConstantEffect{.force_n = {0, 0, -5}}}};
  const auto make = [&] { return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene); };
  HapticsStep step(make(), kOffset);
  States states;
  EXPECT_EQ(reply_to(step, states.at({0.01, 0.01, 0.001})).force_n, Vec3(0, 0, -5)) << "in free space";
  EXPECT_NEAR(reply_to(step, states.at({0.01, 0.01, -0.002})).force_n.z(), -3.0, 1e-6);
  step.replace(make());
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(reply_to(step, states.at({0.01, 0.01, -0.002})).force_n.z(), -3.0, 1e-6);
}

// When a scene is read again, or an object is put down, the new method knows the speed of the hand: viscosity continues smoothly.
TEST(HapticsStep, ATakeoverKeepsTheSpeedOfTheHand) {
  const SurfaceEffects honey{.viscosity = {.damping_ns_per_m = 5.0}};
  const TouchScene surface = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}, honey}}};
  const TouchScene space = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}, .effects = {ViscousEffect{.damping_ns_per_m = 5.0}}};
  for (const TouchScene& scene : {surface, space}) {
    const double z = scene.effects.empty() ? -0.002 : 0.002;
    const auto make = [&] { return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene); };
    HapticsStep step(make(), kOffset);
    States states;
    reply_to(step, states.at({0.0, 0.01, 0.001}));
    for (int i = 1; i <= 60; ++i) {
      if (i == 30) step.replace(make());
      const ForceCommand felt = reply_to(step, states.at({1e-4 * i, 0.01, z}));
      if (i > 10) {
        EXPECT_NEAR(felt.force_n.x(), -0.5, 1e-6) << i;  // 5 Ns/m at 0.1 m/s
      }
    }
  }
}

TEST(HapticsStep, EffectsKeepTheTimeOfTheSamples) {
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}},
                            .effects = {WaveEffect{.waveform = Waveform::sine, .amplitude_n = 1.0, .frequency_hz = 20.0}}};
  HapticsStep step(std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene), kOffset);
  States states;
  for (int i = 1; i <= 100; ++i) {
    const ForceCommand command = reply_to(step, states.at({0.01, 0.01, 0.001}));
    EXPECT_NEAR(command.force_n.z(), std::sin(2.0 * std::numbers::pi * 20.0 * 1e-3 * i), 1e-9);
    EXPECT_EQ(command.visual_offset_m, Vec3::Zero());
  }
}

TEST(HapticsStep, ButtonsOfTheDeviceReachTheEffects) {
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}},
                            .effects = {{ConstantEffect{.force_n = {0, 0, 2}}, EffectSwitch{.button = 2}}}};
  HapticsStep step(std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene), kOffset);
  States states;
  for (int i = 0; i < 80; ++i) {
    DeviceState state = states.at({0.01, 0.01, 0.001});
    state.buttons = i >= 10 && i < 40 ? 2 : 1;
    const ForceCommand command = reply_to(step, state);
    const double gain = std::clamp((i - 10) / 20.0, 0.0, 1.0) - std::clamp((i - 40) / 20.0, 0.0, 1.0);
    EXPECT_NEAR(command.force_n.z(), 2.0 * gain, 1e-9) << i;
    EXPECT_EQ(command.contact, command.force_n.z() != 0.0) << i;
  }
}

TEST(HapticsStep, AMethodTakesOverInFreeSpaceWhereTheDeviceIs) {
  HapticsStep step(make_touch(), kOffset);
  States states;
  reply_to(step, states.at({0.01, 0.01, 0.001}));
  step.replace(make_touch());
  EXPECT_FALSE(reply_to(step, states.at({0.01, 0.01, 0.0005})).contact);
  EXPECT_TRUE(reply_to(step, states.at({0.01, 0.01, -0.0005})).contact);
}

TEST(HapticsStep, UsesNoHeap) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  HapticsStep step(make_touch(), kOffset);
  States states;
  ViewTransform view;
  const AllocationGuard guard;
  for (int i = 0; i < 1000; ++i) {
    view.X_WS[11] = 1e-6F * static_cast<float>(i);
    step.turn_scene(view);
    reply_to(step, states.at({0.00001 * i, 0.0, 0.005 * std::sin(0.1 * i)}));
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(step.counts().contact_steps, 100U);
}

// A tool above the sheet at z = 0: a box of 2 cm, with the grip point in its middle.
struct HeldBox {
  std::unique_ptr<HeldTool> tool = std::make_unique<HeldTool>(std::move(*ToolStep::make(
      made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), {made::shared(made::sheet(0.1, 0.0, 6))}, {.stiffness_n_per_m = 1000.0})));
};

TEST(HapticsStep, AHeldToolReplacesTheProbe) {
  HapticsStep step(make_touch(), kOffset);
  HeldBox box;
  step.hold(box.tool.get());
  States states;
  ForceCommand command = reply_to(step, states.at({0.01, 0.01, 0.02}));
  EXPECT_FALSE(command.contact);
  EXPECT_FALSE(step.is_tool_blocked());
  for (int n = 0; n < 20; ++n) {
    command = reply_to(step, states.at({0.01, 0.01, 0.012 - 0.0001 * n}));
    box.tool->follow();
  }
  command = reply_to(step, states.at({0.01, 0.01, 0.008}));
  EXPECT_TRUE(command.contact);
  EXPECT_NEAR(command.force_n.z(), 2.0, 0.2) << "the box rests on the sheet, far above a probe's contact";
  EXPECT_NEAR(command.visual_offset_m.z(), 0.002, 0.0002);
  EXPECT_GT(command.replied_before, 0U);
  // When the hand holds the box askew, the box turns, and the hand feels a torque.
  DeviceState askew = states.at({0.01, 0.01, 0.008});
  askew.q_WT = turn_by({0.1, 0.0, 0.0});
  for (int n = 0; n < 20; ++n) {
    command = reply_to(step, askew);
    box.tool->follow();
    ++askew.sample;
    askew.sample_time_ns += 1'000'000;
  }
  EXPECT_GT(command.torque_nm.norm(), 0.005);
  EXPECT_GT(command.visual_turn.norm(), 0.01);
  EXPECT_GE(step.counts().max_torque_nm, command.torque_nm.norm());
  EXPECT_GE(step.counts().most_haptons, 1);
  EXPECT_GE(step.counts().haptons, 1U);
  EXPECT_GE(command.haptons, 1U);
  EXPECT_TRUE(step.has_contact());
  EXPECT_EQ(step.free_starts(), 1U);
  // The reported point is a corner of the box, in the pose in which the hand would hold the box.
  const Vec3 p_DV = turn_by({0.1, 0.0, 0.0}).conjugate() * (step.p_STouching() - Vec3(0.01, 0.01, 0.008));
  EXPECT_LT((p_DV.cwiseAbs() - Vec3::Constant(0.01)).norm(), 1e-6) << p_DV.transpose();
}

// Contacts of a tool are damped: live, by the times of the samples, but not by the motion from one session to the next.
TEST(HapticsStep, AHeldToolIsDampedByTheMotionOfThisSession) {
  HapticsStep step(make_touch(), kOffset);
  auto made = *ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), {made::shared(made::sheet(0.1, 0.0, 6))},
                              {.stiffness_n_per_m = 1000.0});
  ASSERT_TRUE(made->damp({{.along_ns_per_m = 5.0}}));
  HeldTool tool(std::move(made));
  step.hold(&tool);
  States states;
  double x = 0.0;
  ForceCommand command;
  const auto slide = [&](double speed, int samples) {
    for (int n = 0; n < samples; ++n) {
      x += 1e-3 * speed;
      command = reply_to(step, states.at({x, 0.01, 0.008}));
      tool.follow();
    }
  };
  for (int n = 0; n < 100; ++n) {
    reply_to(step, states.at({0.0, 0.01, std::max(0.008, 0.012 - 0.0001 * n)}));
    tool.follow();
  }
  slide(0.04, 100);
  EXPECT_NEAR(command.force_n.x(), -5.0 * 0.04, 1e-6);
  step.restart();
  x += 0.005;
  slide(0.0, 1);
  EXPECT_TRUE(command.contact);
  EXPECT_NEAR(command.force_n.x(), 0.0, 1e-9) << "the hand was moved meanwhile";
  slide(0.04, 100);
  EXPECT_NEAR(command.force_n.x(), -5.0 * 0.04, 1e-6);
}

// The scene is moved. A spring to the middle of the sheet, and a vibration in the time of the session, act in addition to the tool.
TEST(HapticsStep, EffectsInFreeSpaceActAtTheGripOfAHeldTool) {
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}},
                            .effects = {SpringEffect{.stiffness_n_per_m = 50.0, .max_force_n = 5.0},
                                        WaveEffect{.direction = {0, 1, 0}, .amplitude_n = 0.5, .frequency_hz = 25.0}}};
  HapticsStep step(std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene), kOffset);
  HeldBox box;
  step.hold(box.tool.get());
  ViewTransform view;
  const Vec3 shift(0.01, -0.02, 0.03);
  for (int i = 0; i < 3; ++i) view.X_WS[static_cast<std::size_t>(4 * i + 3)] = static_cast<float>(shift[i]);
  ASSERT_TRUE(step.turn_scene(view));
  States states;
  for (const bool is_new_session : {false, true}) {
    if (is_new_session) step.restart();
    for (int n = 1; n <= 50; ++n) {
      const Vec3 p_WD(0.02, 0.01, 0.05 + 0.0001 * n);
      const ForceCommand command = reply_to(step, states.at(p_WD));
      box.tool->follow();
      const Vec3 expected = -50.0 * (p_WD - shift) + Vec3(0.0, 0.5 * std::sin(2.0 * std::numbers::pi * 0.025 * n), 0.0);
      ASSERT_LT((command.force_n - expected).norm(), 1e-6) << n;
      EXPECT_TRUE(command.contact);
      EXPECT_EQ(command.torque_nm, Vec3::Zero());
    }
  }
  // The force of the tool's contact is added when the tool rests on the sheet.
  ForceCommand command;
  for (int n = 0; n < 60; ++n) {
    command = reply_to(step, states.at(shift + Vec3(0.0, 0.0, 0.02 - 0.0002 * n)));
    box.tool->follow();
  }
  EXPECT_NEAR(command.force_n.z(), 1000.0 * 0.0018 - 50.0 * 0.0082, 0.05);
  const AllocationGuard guard;
  for (int n = 0; n < 100; ++n) reply_to(step, states.at(shift + Vec3(0.0, 0.0, 0.009)));
  EXPECT_EQ(guard.count(), 0U);
}

// A box of 4 cm that a program lifts to the tool, and one that rises by keyframes.
TEST(HapticsStep, AHeldToolFeelsMovingObjectsAndReportsItsPushOnThoseOfPrograms) {
  for (const bool is_commanded : {true, false}) {
    TouchScene scene;
    TouchObject block;
    block.mesh = made::shared(made::box(Vec3::Constant(-0.02), Vec3::Constant(0.02)));
    if (is_commanded) {
      block.command_pivot = Vec3::Zero();
    } else {
      block.motion = std::make_shared<const KeyframeMotion>(
          Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {0.2, {0.0, 0.0, 0.02}, Quat::Identity()}}, false);
    }
    scene.objects = {{.mesh = made::shared(made::sheet(0.1, 0.0, 6)), .material = {}}, block};
    HapticsStep step(std::make_unique<TouchStep>(*make_method({}, scene), scene), kOffset);
    ToolObstacles obstacles = make_tool_obstacles(scene);
    HeldTool tool(std::move(*ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), obstacles.meshes,
                                            {.stiffness_n_per_m = 1000.0}, obstacles.friction, nullptr, obstacles.part_of)));
    step.hold(&tool, obstacles.parts);
    if (is_commanded) {
      const Keyframe from{0.0, Vec3::Zero(), Quat::Identity()};
      ASSERT_TRUE(step.command(1, {.serial = 1, .from = from, .to = {0.2, {0.0, 0.0, 0.02}, Quat::Identity()}}));
    }
    States states;
    ForceCommand command;
    // The tool is held 15 mm above the block, which rises by 20 mm: 5 mm into the tool.
    for (int n = 0; n < 300; ++n) {
      command = reply_to(step, states.at({0.0, 0.0, 0.045}));
      tool.follow();
      if (n == 100) {
        EXPECT_EQ(command.force_n, Vec3(Vec3::Zero()));
      }
    }
    EXPECT_NEAR(command.force_n.z(), 5.0, 0.01);
    EXPECT_NEAR(command.visual_offset_m.z(), 0.005, 1e-5);
    EXPECT_EQ(command.object, is_commanded ? 1 : -1);
    ASSERT_EQ(command.push.has_value(), is_commanded);
    if (!is_commanded) continue;
    EXPECT_NEAR(command.push->force_n.z(), -5.0, 0.01);
    EXPECT_NEAR(command.push->torque_nm.norm(), 0.0, 1e-3);
  }
}

}  // namespace
}  // namespace hapton
