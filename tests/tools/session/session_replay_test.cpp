#include "tools/session/session_replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "plugin/plugin_effects.h"
#include "tests/standins/paths.h"
#include "tests/support/one_line.h"
#include "tests/tools/session/session_replay_fixture.h"

namespace hapton {
namespace {

TEST_F(SessionReplayTest, ASlideGivesTheSameForcesToTheLastBit) {
  slide(500);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 500U);
  EXPECT_GT(replay.counts().contact_steps, 400U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, OneChangedBitIsFoundAndNamed) {
  slide(100);
  recorded[60].second->force_n.x() = std::nextafter(recorded[60].second->force_n.x(), 1e9);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().different, 1U);
  EXPECT_NE(replay.counts().first_difference.find("sample 61,"), std::string::npos) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, StatesThatWereSkippedAreNotStepped) {
  slide(30);
  for (int n = 0; n < 100; ++n) {
    const DeviceState skipped = next_state();
    live.offer(skipped);
    recorded.emplace_back(skipped, std::nullopt);
    slide(2);
  }
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().steps, 230U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, SamplesWhoseRepliesGotLostAreSteppedToo) {
  slide(300);
  for (std::size_t n = 50; n < 250; n += 3) recorded[n].second.reset();
  for (std::size_t n = 100; n < 130; ++n) recorded[n].second.reset();
  std::uint64_t lost = 0;
  for (const auto& [state, command] : recorded) lost += command ? 0 : 1;
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().lost_replies, lost);
  EXPECT_EQ(replay.counts().compared, 300 - lost);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, RepliesThatOvertookEachOtherArePutInOrder) {
  slide(300);
  SessionReplay replay = make_replay();
  for (const auto& [state, command] : recorded) replay.on_state(state);
  for (std::size_t n = 0; n < 300; n += 10) {
    for (std::size_t k = 10; k-- > 0;) ASSERT_TRUE(replay.on_reply(kSender, *recorded[n + (n == 0 ? 9 - k : k)].second));
    ASSERT_TRUE(replay.on_reply(kSender, *recorded[n].second));  // and once more
  }
  ASSERT_TRUE(replay.finish());
  EXPECT_EQ(replay.counts().compared, 300U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, AViewHoldsFromTheReplyThatNamesIt) {
  slide(60);
  ViewTransform view{.revision = 3};
  view.X_WS[3] = 0.0005F;
  ASSERT_TRUE(live.turn_scene(view));
  slide(100);
  SessionReplay replay = make_replay();
  replay.on_view(view);
  feed(replay);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
  EXPECT_EQ(replay.counts().missing_views, 0U);
}

TEST_F(SessionReplayTest, AMethodHoldsFromTheReplyThatCountsIt) {
  slide(60);
  live.replace(make_sphere_touch("reference"));
  send_setup("reference");
  slide(40);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 100U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

constexpr MaterialChange kSofter = {
    .fields = MaterialChange::kStiffness | MaterialChange::kFrictionDynamic, .stiffness_n_per_m = 600.0, .friction_dynamic = 0.1};
constexpr MaterialChange kHarder = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = 1700.0};

TEST_F(SessionReplayTest, MaterialsHoldFromTheReplyThatCountsThem) {
  slide(200);
  tune(kSofter);
  slide(150);
  tune(kHarder);
  slide(30);  // in the middle of the fade
  tune(kSofter);
  slide(200);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 580U);
  EXPECT_GT(replay.counts().contact_steps, 500U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;

  // This test can fail: with another stiffness the forces differ.
  materials[{kSender, 2U}].objects[0].change.stiffness_n_per_m = 1701.0;
  SessionReplay wrong = make_replay();
  feed(wrong);
  EXPECT_GT(wrong.counts().different, 29U);
}

// A new method begins with the materials of that moment, whether the method or the materials changed first between two replies.
TEST_F(SessionReplayTest, MethodsAndMaterialsThatChangeBetweenTwoRepliesAreReplayedInTheirOrder) {
  slide(100);
  std::vector<Material> tuned = tune(kSofter);
  for (const bool is_method_first : {true, false}) {
    const auto change_method = [&] {
      auto touch = make_sphere_touch(is_method_first ? "reference" : "proxy");
      touch->set_materials(tuned);
      live.replace(std::move(touch));
      send_setup(is_method_first ? "reference" : "proxy");
    };
    slide(20);
    if (is_method_first) change_method();
    tuned = tune(is_method_first ? kHarder : kSofter);
    if (!is_method_first) change_method();
    slide(60);
  }
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 260U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, ForcesOfUnnamedMaterialsAreNotCompared) {
  slide(100);
  tune(kSofter);
  materials.clear();
  slide(50);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 100U);
  EXPECT_EQ(replay.counts().unknown_method, 50U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, ARecordingThatBeginsAfterAChangeHasItsMaterials) {
  slide(100);
  tune(kSofter);
  slide(50);
  recorded.erase(recorded.begin(), recorded.begin() + 120);
  slide_in_again(150);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_GT(replay.counts().compared, 30U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, AMethodThatCameAmongLostRepliesIsComparedFromFreeSpaceOn) {
  slide(60);
  live.replace(make_sphere_touch("smooth"));
  send_setup("smooth");
  slide(40);
  for (std::size_t n = 55; n < 65; ++n) recorded[n].second.reset();
  slide_in_again(100);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().lost_replies, 10U);
  EXPECT_GE(replay.counts().not_compared, 35U);
  EXPECT_GE(replay.counts().compared, 55U + 39U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, ForcesOfAnUnnamedMethodAreNotCompared) {
  slide(60);
  live.replace(make_sphere_touch("reference"));  // its setup got lost
  slide(40);
  live.replace(make_sphere_touch("proxy"));
  send_setup("proxy");
  for (int lap = 0; lap < 2; ++lap) {
    const std::uint64_t before = sample;
    slide_in_again(before);
    sample += before;
  }
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().unknown_method, 40U);
  // The last force of the unknown method fades out in free space.
  EXPECT_NEAR(static_cast<double>(replay.counts().not_compared), 1e3 * ForceFade::kInAirS, 1.0);
  EXPECT_EQ(replay.counts().compared + replay.counts().not_compared, 160U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, ARecordingThatBeginsInContactIsComparedFromFreeSpaceOn) {
  slide(100);
  recorded.erase(recorded.begin(), recorded.begin() + 50);
  slide_in_again(100);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().not_compared, 50U);
  EXPECT_EQ(replay.counts().compared, 50U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, ARecordingWithoutSetupsIsRejectedInOneLine) {
  setups.clear();
  slide(1);
  SessionReplay replay = make_replay();
  const auto done = replay.on_reply(kSender, *recorded[0].second);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("does not name"), std::string::npos);
  EXPECT_THAT(done.error().what, IsOneLine());
}

// A hub that began to record later has not received the view itself, only the setup that names it.
TEST_F(SessionReplayTest, AViewThatOnlyASetupNamesHoldsAsWell) {
  slide(60);
  ViewTransform view{.revision = 3};
  view.X_WS[3] = 0.0005F;
  ASSERT_TRUE(live.turn_scene(view));
  send_setup("proxy");
  slide(100);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 160U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
  EXPECT_EQ(replay.counts().missing_views, 0U);
}

TEST_F(SessionReplayTest, ForcesInAViewThatIsNotRecordedAreNotCompared) {
  slide(60);
  ViewTransform view{.revision = 3};
  view.X_WS[3] = 0.0005F;
  ASSERT_TRUE(live.turn_scene(view));
  HapticsSetup other;
  other.view_revision = 3;
  setups[{kSender + 1, 0U}] = other;  // another node's
  slide(100);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 60U);
  EXPECT_EQ(replay.counts().unknown_method, 100U);
  EXPECT_EQ(replay.counts().missing_views, 100U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// The torque is felt and the visual offset is drawn, so a change of either of them is a difference, too.
TEST_F(SessionReplayTest, OneChangedBitOfAnyResultIsADifference) {
  slide(100);
  const auto change_last_bit = [](double& number) { number = std::nextafter(number, 1e9); };
  recorded[40].second->contact = !recorded[40].second->contact;
  change_last_bit(recorded[50].second->torque_nm.y());
  change_last_bit(recorded[60].second->visual_offset_m.z());
  recorded[70].second->force_n.x() += 0.25;
  recorded[80].second->force_n.x() += 0.125;
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 100U);
  EXPECT_EQ(replay.counts().different, 5U);
  EXPECT_NEAR(replay.counts().max_difference_n, 0.25, 1e-12);
  EXPECT_NE(replay.counts().first_difference.find("sample 41,"), std::string::npos) << replay.counts().first_difference;
}

TEST_F(SessionReplayTest, TheSetupOfAnotherNodeDoesNotNameTheMethod) {
  const HapticsSetup setup = setups.at({kSender, 0U});
  setups.clear();
  setups[{kSender + 1, 0U}] = setup;
  slide(1);
  SessionReplay replay = make_replay();
  const auto done = replay.on_reply(kSender, *recorded[0].second);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("does not name"), std::string::npos);
}

TEST_F(SessionReplayTest, ARecordingThatBeginsWithAnUnnamedMethodIsComparedFromTheNamedOneOn) {
  slide(60);
  live.replace(make_sphere_touch("reference"));
  send_setup("reference");
  slide(40);
  slide_in_again(100);
  setups.erase({kSender, 0U});  // got lost
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().unknown_method, 60U);
  EXPECT_GE(replay.counts().not_compared, 40U) << "in contact before the first step in free space";
  EXPECT_GE(replay.counts().compared, 30U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// ---- objects that move by keyframes, whose time is in the replies ----

std::unique_ptr<TouchStep> make_moving_touch() {
  TouchScene scene = one_sphere();
  scene.objects[0].motion = make_turn_to_and_fro();
  return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene);
}

struct MovingReplayTest : SessionReplayTest {
  MovingReplayTest() : SessionReplayTest(make_moving_touch()) {}

  SessionReplay make_replay() { return replay_with(make_moving_touch); }
};

TEST_F(MovingReplayTest, MovingObjectsGiveTheSameForcesToTheLastBit) {
  slide(500);
  for (std::size_t n = 50; n < 250; n += 3) recorded[n].second.reset();
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_GT(replay.counts().compared, 400U);
  EXPECT_GT(replay.counts().contact_steps, 300U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// The objects had moved for a while, and the first reply of the recording was lost.
TEST_F(MovingReplayTest, ARecordingThatBeginsLaterKnowsWhereObjectsWere) {
  slide(100);
  slide_in_again(100);
  recorded.erase(recorded.begin(), recorded.begin() + 100);
  recorded[0].second.reset();
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_GT(replay.counts().compared, 40U);
  EXPECT_GT(replay.counts().contact_steps, 20U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// ---- effects, which remember time and velocity in free space ----

TouchScene sphere_with_effects() {
  TouchScene scene = one_sphere();
  scene.objects[0].effects = {.progressive = {.n_per_m2 = 1e5},
                              .layers = {},
                              .bumps = {.height_m = 2e-4, .length_m = 2e-3},
                              .viscosity = {.damping_ns_per_m = 3},
                              .snap = {.range_m = 2e-3},
                              .tap = {.ns_per_m = 5}};
  scene.effects = {ViscousEffect{.damping_ns_per_m = 1.0, .volume = EffectVolume::ball(Vec3::Zero(), 0.0595)},
                   WaveEffect{.frequency_hz = 37, .volume = EffectVolume::ball(Vec3::Zero(), 0.0595)}};
  return scene;
}

std::unique_ptr<TouchStep> make_effects_touch() {
  const TouchScene scene = sphere_with_effects();
  return std::make_unique<TouchStep>(*make_method({.name = "proxy"}, scene), scene);
}

struct EffectsReplayTest : SessionReplayTest {
  EffectsReplayTest() : SessionReplayTest(make_effects_touch()) {}

  SessionReplay make_replay() { return replay_with(make_effects_touch); }
};

TEST_F(EffectsReplayTest, EffectsGiveTheSameForcesToTheLastBit) {
  slide(500);
  live.replace(make_effects_touch());
  send_setup("proxy");
  slide(200);
  for (std::size_t n = 50; n < 250; n += 3) recorded[n].second.reset();
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_GT(replay.counts().compared, 600U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
  EXPECT_EQ(replay.counts().not_compared, 0U);
}

TEST_F(EffectsReplayTest, WhatBeganBeforeTheRecordingIsNotCompared) {
  slide(300);
  slide_in_again(300);
  recorded.erase(recorded.begin(), recorded.begin() + 100);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 0U);
  EXPECT_EQ(replay.counts().not_compared, 250U);
  EXPECT_EQ(replay.counts().different, 0U);
}

// The haptics node was restarted after a long gap: the recording cannot tell that from a gap without a restart.
TEST_F(EffectsReplayTest, AfterALongGapNothingIsCompared) {
  slide(100);
  sample += 200;
  live.restart();
  slide(100);
  SessionReplay replay = make_replay();
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 100U);
  EXPECT_EQ(replay.counts().not_compared, 100U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

// With an effect from a shared library beside the method.
struct PluginReplayTest : SessionReplayTest {
  SimulatedClock clock;
  PluginEffects effects{clock};
  PluginEffects replay_effects{clock};

  void add(PluginEffects& into, const std::string& parameters) {
    ASSERT_TRUE(into.add(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":" + parameters)));
  }
  void record(const std::string& parameters) {
    add(effects, parameters);
    live.use_effects(&effects);
    slide(200);
    put_text(to_text({.name = "proxy"}) + effects.to_text(), setups.begin()->second.method);
  }
  std::string feed_until_error(SessionReplay& replay) {
    for (const auto& [state, command] : recorded) {
      replay.on_state(state);
      if (const auto done = replay.on_reply(kSender, *command); !done) return done.error().what;
    }
    return "";
  }
};

TEST_F(PluginReplayTest, TheSameFileAndParametersGiveTheSameForces) {
  record("does=copy");
  add(replay_effects, "does=copy");
  SessionReplay replay = make_replay();
  replay.use_effects(&replay_effects);
  feed(replay);
  EXPECT_EQ(replay.counts().compared, 200U);
  EXPECT_EQ(replay.counts().different, 0U) << replay.counts().first_difference;
}

TEST_F(PluginReplayTest, WithoutTheEffectOrWithAnotherNothingIsReplayed) {
  record("does=copy");
  SessionReplay without = make_replay();
  EXPECT_NE(feed_until_error(without).find("--effect FILE.so"), std::string::npos);
  add(replay_effects, "does=copy,n=2");
  SessionReplay other = make_replay();
  other.use_effects(&replay_effects);
  EXPECT_NE(feed_until_error(other).find("same parameters"), std::string::npos);
}

TEST_F(PluginReplayTest, AnEffectTooManyIsNamed) {
  slide(200);
  add(replay_effects, "does=copy");
  SessionReplay replay = make_replay();
  replay.use_effects(&replay_effects);
  EXPECT_NE(feed_until_error(replay).find("leave --effect out"), std::string::npos);
}

TEST_F(PluginReplayTest, AnEffectThatWasCutOffCannotBeReplayed) {
  record("does=nan,after=100");
  add(replay_effects, "does=nan,after=100");
  SessionReplay replay = make_replay();
  replay.use_effects(&replay_effects);
  EXPECT_NE(feed_until_error(replay).find("was cut off"), std::string::npos);
}

}  // namespace
}  // namespace hapton
