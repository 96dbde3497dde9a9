// What the picture shows of the scene and of the hub, and how often it is drawn.
#include <gtest/gtest.h>

#include "tests/support/time_units.h"
#include "tests/vision_node/vision_step_fixture.h"

namespace hapton {
namespace {

TEST_F(VisionStepTest, WithoutTheHubNothingIsSaidOfTheLastForce) {
  VisionStep step(settings());
  step.note_join();
  ProbeState state = state_at(0.0, 1);
  state.contact = true;
  state.object = 0;
  state.force_n = {0.0, 0.0, 1.25};
  step.receive(state);
  ASSERT_TRUE(step.wants_picture(0, screen_));
  EXPECT_NE(step.compose(0).hud.find("1.25 N"), std::string::npos);
  step.end_frame(0, 5 * kMs, screen_);
  step.note_loss();
  ASSERT_TRUE(step.wants_picture(1000 * kMs, screen_)) << "though nothing moves";
  const std::string hud = step.compose(1000 * kMs).hud;
  EXPECT_NE(hud.find("waiting for the hub"), std::string::npos) << hud;
  EXPECT_EQ(hud.find("1.25 N"), std::string::npos) << hud;
}

TEST_F(VisionStepTest, WithoutALimitEverythingThatMovesIsDrawn) {
  VisionStepSettings unlimited = settings();
  unlimited.max_rate_hz = 0.0;
  VisionStep step(unlimited);
  step.note_join();
  int pictures = 0;
  for (int ms = 0; ms < 100; ++ms) {
    step.receive(state_at(0.001 * ms, static_cast<std::uint64_t>(ms)));
    pictures += draw_if_wanted(step, ms * kMs);
  }
  EXPECT_EQ(pictures, 100);
  const auto drawn = step.end_frame(100 * kMs, 105 * kMs, screen_);
  ASSERT_TRUE(drawn);
  EXPECT_EQ(drawn->rest_ns, 0U) << "it can draw again at once";
}

TEST_F(VisionStepTest, KeysHideTheHelpAndTheDepthCuesAtOnce) {
  VisionStep step(settings());
  ASSERT_TRUE(draw_if_wanted(step, 0));
  const auto press = [&](char key, std::int64_t now_ns) {
    WindowEvent event;
    event.key = key;
    step.handle(event, screen_);
    step.take_requests();
    EXPECT_TRUE(step.wants_picture(now_ns, screen_)) << key;
    const VisionStep::Shown shown = step.compose(now_ns);
    step.end_frame(now_ns, now_ns + 5 * kMs, screen_);
    return std::pair(!shown.help.empty(), shown.depth_cues);
  };
  EXPECT_EQ(press('k', 20 * kMs), std::pair(false, true));
  EXPECT_EQ(press('g', 40 * kMs), std::pair(false, false));
  EXPECT_EQ(press('k', 60 * kMs), std::pair(true, false));
  EXPECT_EQ(press('g', 80 * kMs), std::pair(true, true));
}

TEST_F(VisionStepTest, WhatTheStylusHoldsAndTheStereoModeAreInTheCornerAtOnce) {
  VisionStepSettings with_names = settings();
  with_names.names = {{"hood", "tin"}, {"peg", "steel"}};
  VisionStep step(with_names);
  step.note_join();
  step.receive(state_at(0.0, 1));
  ASSERT_TRUE(draw_if_wanted(step, 0));
  ASSERT_FALSE(draw_if_wanted(step, 20 * kMs));
  step.set_held_object(1);
  EXPECT_EQ(step.held_object(), 1);
  ASSERT_TRUE(step.wants_picture(40 * kMs, screen_));
  EXPECT_NE(step.compose(40 * kMs).hud.find("holding peg (steel)"), std::string::npos);
  step.end_frame(40 * kMs, 45 * kMs, screen_);
  step.set_stereo("emulate", true);
  ASSERT_TRUE(step.wants_picture(60 * kMs, screen_));
  EXPECT_NE(step.compose(60 * kMs).hud.find("emulate"), std::string::npos);
  step.end_frame(60 * kMs, 65 * kMs, screen_);
  EXPECT_TRUE(draw_if_wanted(step, 80 * kMs)) << "the eyes in turn";
  step.set_stereo("mono", false);
  EXPECT_TRUE(draw_if_wanted(step, 100 * kMs));
  EXPECT_FALSE(draw_if_wanted(step, 120 * kMs));
}

TEST_F(VisionStepTest, AnotherSceneHasItsOwnViewAndItsOwnNames) {
  VisionStepSettings first = settings();
  first.names = {{"hood", "tin"}, {"glass", ""}};
  VisionStep step(first);
  step.note_join();
  ProbeState state = state_at(0.0, 1);
  state.contact = true;
  state.object = 0;
  step.receive(state);
  ASSERT_TRUE(draw_if_wanted(step, 0));
  WindowEvent key;
  key.key = '+';
  step.handle(key, screen_);
  ASSERT_TRUE(draw_if_wanted(step, 20 * kMs));
  ASSERT_TRUE(step.is_scene_at_rest(500 * kMs));
  const Framing home = frame_sphere(Vec3(0.05, 0.0, 0.0), 0.1, 0.063);
  const Vec3 p_SO(0.02, 0.01, 0.0);
  const std::vector<ObjectName> names = {{"door", ""}, {"lock", ""}};
  step.change_scene(home, p_SO, 0.03, names, false);
  EXPECT_FALSE(step.is_scene_at_rest(500 * kMs)) << "it is not drawn yet";
  ASSERT_TRUE(step.wants_picture(500 * kMs, screen_));
  const VisionStep::Shown shown = step.compose(500 * kMs);
  EXPECT_EQ(shown.framing.p_WC, home.p_WC);
  EXPECT_LT(shown.framing.view_m, home.view_m) << "the viewer's zoom stays";
  EXPECT_NE(shown.hud.find("touching door"), std::string::npos) << shown.hud;
  step.end_frame(500 * kMs, 505 * kMs, screen_);
  EXPECT_FALSE(step.is_scene_at_rest(600 * kMs));
  step.change_scene(home, p_SO, 0.03, names, true);
  EXPECT_EQ(step.compose(700 * kMs).framing.view_m, home.view_m) << "the view begins anew";
  key.key = 'f';
  step.handle(key, screen_);
  step.take_requests();
  const Framing looked_at = step.compose(720 * kMs).framing;
  EXPECT_LT((looked_at.p_WC - p_SO).norm(), 1e-12);
  EXPECT_NEAR(looked_at.view_m, 2.0 * 1.1 * 0.03, 1e-9) << "the sphere and a margin";
}

}  // namespace
}  // namespace hapton
