#include "vision_node/vision_step.h"

#include <gtest/gtest.h>

#include "tests/support/time_units.h"
#include "tests/vision_node/vision_step_fixture.h"
#include "vision_node/hud_text.h"

namespace hapton {
namespace {

TEST_F(VisionStepTest, TheHudSaysThatHapticsPreparesUntilTheHubIsLost) {
  VisionStep step(settings());
  step.note_join();
  ProbeState state = state_at(0.0, 1);
  state.status = ProbeStatus::no_haptics;
  step.receive(state);
  step.set_preparing(2.0, 0);
  EXPECT_NE(step.compose(0).hud.find("prepares the scene, 2 s"), std::string::npos);
  step.note_loss();
  step.note_join();
  step.receive(state);
  step.request_redraw();
  EXPECT_EQ(step.compose(kMs).hud.find("prepares"), std::string::npos);
}

// A haptics node that has been silent for so long counts as ended.
TEST_F(VisionStepTest, AHapticsNodeThatHasBeenSilentForThreeSecondsPreparesNothing) {
  VisionStep step(settings());
  step.note_join();
  ProbeState state = state_at(0.0, 1);
  state.status = ProbeStatus::no_haptics;
  step.receive(state);
  step.set_preparing(11.0, 0);
  ASSERT_TRUE(draw_if_wanted(step, 0));
  step.set_preparing(12.0, 1000 * kMs);
  EXPECT_NE(step.compose(3999 * kMs).hud.find("prepares the scene, 12 s"), std::string::npos);
  ASSERT_TRUE(step.wants_picture(4400 * kMs, screen_)) << "though nothing moves";
  const std::string hud = step.compose(4400 * kMs).hud;
  EXPECT_NE(hud.find("no haptics_node replies"), std::string::npos) << hud;
  step.set_preparing(1.0, 5000 * kMs);
  EXPECT_NE(step.compose(5000 * kMs).hud.find("prepares the scene, 1 s"), std::string::npos) << "the next one";
}

TEST_F(VisionStepTest, ANoticeSaysHowFarAwayTheSceneIsAsItIsTurnedNow) {
  VisionStepSettings with_far_scene = settings();
  with_far_scene.p_SO = Vec3(2.0, 0.0, 0.0);
  with_far_scene.scene_radius_m = 0.05;
  VisionStep step(with_far_scene);
  step.note_join();
  ProbeState state = state_at(0.0, 1);
  step.receive(state);
  EXPECT_EQ(step.compose(0).notice, "");
  state.status = ProbeStatus::out_of_reach;
  step.receive(state);
  EXPECT_TRUE(step.wants_picture(1000 * kMs, screen_)) << "a notice is drawn though nothing moves";
  EXPECT_NE(step.compose(1000 * kMs).notice.find("100 mm across, 2 m away"), std::string::npos);
  state.status = ProbeStatus::ok;
  step.receive(state);
  EXPECT_EQ(step.compose(2000 * kMs).notice, "");
}

TEST_F(VisionStepTest, TheHudNamesTheTouchedObjectOfTheSameScene) {
  VisionStepSettings with_names = settings();
  with_names.names = {{"hood", "tin"}, {"glass", ""}};
  VisionStep step(with_names);
  step.note_join();
  ProbeState state = state_at(0.0, 1);
  state.contact = true;
  state.object = 0;
  step.receive(state);
  EXPECT_NE(step.compose(0).hud.find("touching hood (tin)"), std::string::npos);
  state.object = 1;
  step.receive(state);
  EXPECT_NE(step.compose(kMs).hud.find("touching glass"), std::string::npos) << "at once, not with the next numbers";
  state.object = 7;
  step.receive(state);
  EXPECT_EQ(step.compose(2 * kMs).hud.find("glass"), std::string::npos);
  state.object = 0;
  step.receive(state);
  step.set_other_scene(true);
  step.request_redraw();
  EXPECT_EQ(step.compose(3 * kMs).hud.find("hood"), std::string::npos) << "the numbers are those of another scene";
}

TEST_F(VisionStepTest, TheHudDoesNotNameWhatIsHeldInAnotherScene) {
  VisionStepSettings with_names = settings();
  with_names.names = {{"hood", "tin"}};
  VisionStep step(with_names);
  step.note_join();
  step.receive(state_at(0.0, 1));
  step.set_held_object(0);
  EXPECT_NE(step.compose(0).hud.find("holding hood"), std::string::npos);
  step.set_other_scene(true);
  step.request_redraw();
  EXPECT_EQ(step.compose(kMs).hud.find("hood"), std::string::npos) << "the number is that of another object";
}

TEST_F(VisionStepTest, ATurnedKnobIsDrawnAndSentAndAStillOneIsNot) {
  VisionStep step(settings());
  step.note_join();
  step.receive(state_at(0.0, 1, 0));
  while (step.take_message(0)) {
  }
  step.receive(state_at(0.0, 2, 1));
  EXPECT_TRUE(draw_if_wanted(step, 0));
  step.turn_dials(Vec3::Zero());
  EXPECT_FALSE(draw_if_wanted(step, 50 * kMs));
  EXPECT_FALSE(step.take_message(50 * kMs));
  step.turn_dials(Vec3(0, 2, 0));
  EXPECT_TRUE(draw_if_wanted(step, 100 * kMs));
  EXPECT_EQ(step.interaction().dials().degrees, Vec3(0, 2, 0));
  const auto sent = step.take_message(100 * kMs);
  ASSERT_TRUE(sent);
  EXPECT_TRUE(std::holds_alternative<ViewTransform>(*sent));
}

TEST_F(VisionStepTest, DrawsOnceThenRestsWhileNothingMoves) {
  VisionStep step(settings());
  int pictures = 0;
  for (int ms = 0; ms < 10000; ++ms) {
    step.receive(state_at(0.01, static_cast<std::uint64_t>(ms)));
    pictures += draw_if_wanted(step, ms * kMs);
  }
  EXPECT_LE(pictures, 3) << "the first, and the HUD's";
  EXPECT_GE(pictures, 1);
  EXPECT_GT(step.frames().skipped(), 9000u);
}

TEST_F(VisionStepTest, DrawsWhatMovesAtMostAtTheLimit) {
  VisionStep step(settings());
  int pictures = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    step.receive(state_at(0.0001 * ms, static_cast<std::uint64_t>(ms)));
    pictures += draw_if_wanted(step, ms * kMs);
  }
  EXPECT_GE(pictures, 60);
  EXPECT_LE(pictures, 101);
}

TEST_F(VisionStepTest, AMovedCameraIsDrawnAndNotSent) {
  VisionStep step(settings());
  step.note_join();
  while (step.take_message(0)) {
  }
  ASSERT_TRUE(draw_if_wanted(step, 0));
  ASSERT_FALSE(draw_if_wanted(step, 20 * kMs));
  WindowEvent plus;
  plus.key = '+';
  step.handle(plus, screen_);
  ASSERT_TRUE(step.wants_picture(40 * kMs, screen_));
  EXPECT_LT(step.compose(40 * kMs).framing.view_m, settings().home.view_m);
  step.end_frame(40 * kMs, 45 * kMs, screen_);
  EXPECT_FALSE(draw_if_wanted(step, 60 * kMs));
  EXPECT_FALSE(step.take_message(60 * kMs)) << "the touched scene stays where it is";
}

TEST_F(VisionStepTest, TheSceneRestsAWhileAfterItWasTurnedThoughTheProbeMovesOn) {
  VisionStep step(settings());
  EXPECT_FALSE(step.is_scene_at_rest(1000 * kMs)) << "nothing has been drawn";
  ASSERT_TRUE(draw_if_wanted(step, 0));
  step.turn_dials(Vec3(0, 2, 0));
  EXPECT_FALSE(step.is_scene_at_rest(900 * kMs)) << "turned and not yet drawn";
  ASSERT_TRUE(draw_if_wanted(step, 1000 * kMs));
  EXPECT_FALSE(step.is_scene_at_rest(1100 * kMs));
  for (int ms = 1100; ms < 1300; ms += 20) {
    step.receive(state_at(0.0005 * ms, static_cast<std::uint64_t>(ms)));
    draw_if_wanted(step, ms * kMs);
  }
  EXPECT_TRUE(step.is_scene_at_rest(1300 * kMs));
}

// While the shape still changes, full detail, which takes time, would be out of date at once.
TEST_F(VisionStepTest, TheSceneRestsAWhileAfterItsShapeChanged) {
  VisionStep step(settings());
  ASSERT_TRUE(draw_if_wanted(step, 0));
  ASSERT_TRUE(step.is_scene_at_rest(500 * kMs));
  step.reshape_scene();
  EXPECT_FALSE(step.is_scene_at_rest(500 * kMs)) << "not yet drawn";
  ASSERT_TRUE(draw_if_wanted(step, 500 * kMs));
  EXPECT_FALSE(step.is_scene_at_rest(600 * kMs));
  EXPECT_TRUE(step.is_scene_at_rest(700 * kMs));
  EXPECT_FALSE(draw_if_wanted(step, 720 * kMs)) << "nothing new";
}

TEST_F(VisionStepTest, AHeadThatMovesByMoreThanHalfAPixelIsDrawn) {
  VisionStepSettings made = settings();
  made.home = frame_sphere(Vec3::Zero(), 0.12, 0.063);
  VisionStep step(made);
  ASSERT_TRUE(draw_if_wanted(step, 0));
  ASSERT_TRUE(step.is_scene_at_rest(500 * kMs));
  const double half_pixel_m = 0.5 * screen_.screen.width_m / screen_.picture.width_px;
  step.set_head({{0.9 * half_pixel_m, 0.0, 0.6}, Quat::Identity()});
  EXPECT_FALSE(draw_if_wanted(step, 500 * kMs));
  EXPECT_TRUE(step.is_scene_at_rest(500 * kMs));
  step.request_redraw();
  ASSERT_TRUE(step.wants_picture(520 * kMs, screen_));
  EXPECT_EQ(step.compose(520 * kMs).framing.head.p_RH.x(), 0.0) << "nor does it change a picture that is drawn for something else";
  step.end_frame(520 * kMs, 525 * kMs, screen_);
  step.set_head({{1.1 * half_pixel_m, 0.0, 0.6}, Quat::Identity()});
  ASSERT_TRUE(step.wants_picture(540 * kMs, screen_));
  EXPECT_FALSE(step.is_scene_at_rest(1000 * kMs));
  EXPECT_EQ(step.compose(540 * kMs).framing.head.p_RH.x(), 1.1 * half_pixel_m);
  step.end_frame(540 * kMs, 545 * kMs, screen_);
  EXPECT_FALSE(step.wants_picture(560 * kMs, screen_));
  EXPECT_FALSE(step.is_scene_at_rest(600 * kMs));
  EXPECT_TRUE(step.is_scene_at_rest(700 * kMs));
  // The head turns without a change of its position: the eyes move.
  step.set_head({{1.1 * half_pixel_m, 0.0, 0.6}, Quat(Eigen::AngleAxisd(0.1, Vec3::UnitZ()))});
  EXPECT_TRUE(draw_if_wanted(step, 720 * kMs));
}

TEST_F(VisionStepTest, KeysMoveTheHeadBeforeTheScreenAndTheHudSaysWhereItIs) {
  VisionStepSettings made = settings();
  made.home = frame_sphere(Vec3::Zero(), 0.12, 0.063);
  VisionStep step(made);
  ASSERT_TRUE(draw_if_wanted(step, 0));
  WindowEvent right;
  right.navigation_key = WindowEvent::NavigationKey::right;
  for (int n = 0; n < 3; ++n) step.handle(right, screen_);
  step.take_requests();
  ASSERT_TRUE(step.wants_picture(500 * kMs, screen_));
  const VisionStep::Shown shown = step.compose(500 * kMs);
  EXPECT_NEAR(shown.framing.head.p_RH.x(), 0.03, 1e-15);
  EXPECT_NE(shown.hud.find("head 3 0 60 cm"), std::string::npos) << shown.hud;
  step.end_frame(500 * kMs, 505 * kMs, screen_);
  WindowEvent home;
  home.navigation_key = WindowEvent::NavigationKey::home;
  step.handle(home, screen_);
  step.take_requests();
  ASSERT_TRUE(step.wants_picture(520 * kMs, screen_));
  EXPECT_EQ(step.compose(520 * kMs).framing.head.p_RH, Head().p_RH);
}

TEST_F(VisionStepTest, PlotsAreSwitchedByAKeyAndKeepThePictureGoing) {
  VisionStep step(settings());
  step.note_join();
  step.receive(state_at(0.0, 1), 0);
  ASSERT_TRUE(draw_if_wanted(step, 0));
  EXPECT_TRUE(step.compose(0).plots.empty());
  WindowEvent curves;
  curves.key = 'c';
  step.handle(curves, screen_);
  step.take_requests();
  ASSERT_TRUE(step.wants_picture(20 * kMs, screen_));
  EXPECT_EQ(step.compose(20 * kMs).plots.size(), 2u);
  step.end_frame(20 * kMs, 25 * kMs, screen_);
  int pictures = 0;
  for (int ms = 30; ms < 1030; ms += 10) pictures += draw_if_wanted(step, ms * kMs);
  EXPECT_GE(pictures, 9);
  EXPECT_LE(pictures, 11);
  EXPECT_TRUE(step.is_scene_at_rest(1030 * kMs)) << "the scene itself is not drawn again";
  step.note_loss();
  for (int ms = 1030; ms < 1430; ms += 10) draw_if_wanted(step, ms * kMs);
  EXPECT_FALSE(draw_if_wanted(step, 1900 * kMs)) << "nothing new comes";
}

TEST_F(VisionStepTest, TheHudSaysWhatIsWrongWithTheTracker) {
  VisionStep step(settings());
  step.set_head_notice("nobody replies");
  EXPECT_NE(step.compose(0).hud.find("\nHEAD: nobody replies"), std::string::npos);
}

TEST_F(VisionStepTest, ThePointersSurfaceIsWantedWhereTheHandIsLed) {
  VisionStep step(settings());
  WindowEvent event;
  event.kind = WindowEvent::Kind::move;
  EXPECT_FALSE(step.wants_surface(event));
  event.kind = WindowEvent::Kind::press;
  event.button = WindowEvent::Button::right;
  EXPECT_FALSE(step.wants_surface(event));
  event.button = WindowEvent::Button::left;
  EXPECT_TRUE(step.wants_surface(event));
  step.handle(event, screen_, Vec3(0.01, 0.0, 0.02));
  event.kind = WindowEvent::Kind::move;
  EXPECT_TRUE(step.wants_surface(event));
}

TEST_F(VisionStepTest, FLooksAtTheSceneWhereItIsTurnedTo) {
  VisionStepSettings framed = settings();
  framed.p_SO = Vec3(0.1, 0.0, 0.0);
  framed.scene_radius_m = 0.03;
  framed.dials.turn(2, 90.0);
  VisionStep step(framed);
  WindowEvent key;
  key.key = 'f';
  step.handle(key, screen_);
  step.take_requests();
  EXPECT_LT((step.compose(0).framing.p_WC - Vec3(0.0, 0.1, 0.0)).norm(), 1e-12);
}

TEST_F(VisionStepTest, AModeThatAlternatesTheEyesNeverRests) {
  VisionStepSettings alternating = settings();
  alternating.always_changing = true;
  VisionStep step(alternating);
  int pictures = 0;
  for (int ms = 0; ms < 1000; ++ms) pictures += draw_if_wanted(step, ms * kMs);
  EXPECT_NEAR(pictures, 100, 2);
}

TEST_F(VisionStepTest, DialsCullAndAnUncoveredWindowCallForAPicture) {
  VisionStep step(settings());
  ASSERT_TRUE(draw_if_wanted(step, 0));
  ASSERT_FALSE(draw_if_wanted(step, 20 * kMs));
  WindowEvent event;
  event.key = 'y';
  step.handle(event, screen_);
  EXPECT_TRUE(draw_if_wanted(step, 40 * kMs));
  EXPECT_FALSE(draw_if_wanted(step, 60 * kMs));
  event.key = 'b';
  step.handle(event, screen_);
  step.take_requests();
  EXPECT_TRUE(step.wants_picture(80 * kMs, screen_));
  EXPECT_FALSE(step.compose(80 * kMs).cull);
  step.end_frame(80 * kMs, 85 * kMs, screen_);
  EXPECT_FALSE(draw_if_wanted(step, 100 * kMs));
  step.request_redraw();
  EXPECT_TRUE(draw_if_wanted(step, 120 * kMs));
}

TEST_F(VisionStepTest, EveryPictureIsReportedWithTheSampleItShows) {
  VisionStep step(settings());
  step.note_join();
  step.receive(state_at(0.01, 41));
  step.receive(state_at(0.02, 42));
  ASSERT_TRUE(step.wants_picture(0, screen_));
  step.compose(0);
  const auto drawn = step.end_frame(0, 5 * kMs, screen_);
  ASSERT_TRUE(drawn);
  EXPECT_EQ(drawn->echo_sample, 42u);
  EXPECT_EQ(drawn->echo_sample_time_ns, 42 * kMs);
  EXPECT_FALSE(drawn->unchanged);
  EXPECT_FALSE(step.take_unchanged_ack());
  EXPECT_FALSE(step.wants_picture(50 * kMs, screen_));
  EXPECT_FALSE(step.take_unchanged_ack()) << "no state has come since";
}

TEST_F(VisionStepTest, SaysWhenItWouldDrawAgain) {
  VisionStepSettings slow = settings();
  slow.max_rate_hz = 20.0;
  VisionStep step(slow);
  step.note_join();
  step.receive(state_at(0.01, 41));
  step.compose(0);
  EXPECT_EQ(step.end_frame(0, 5 * kMs, screen_)->rest_ns, 45 * kMs);
  EXPECT_EQ(step.end_frame(100 * kMs, 190 * kMs, screen_)->rest_ns, 0);
}

TEST_F(VisionStepTest, AnUnchangedStateIsReportedOnce) {
  VisionStep step(settings());
  step.note_join();
  step.receive(state_at(0.01, 41));
  ASSERT_TRUE(draw_if_wanted(step, 0));
  step.receive(state_at(0.01 + 1e-9, 42));
  ASSERT_FALSE(draw_if_wanted(step, 100 * kMs));
  const auto same = step.take_unchanged_ack();
  ASSERT_TRUE(same);
  EXPECT_TRUE(same->unchanged);
  EXPECT_EQ(same->echo_sample, 42U);
  EXPECT_FALSE(step.take_unchanged_ack());
}

TEST_F(VisionStepTest, OnlyAStateThatWasComparedIsReportedAsUnchanged) {
  VisionStep step(settings());
  step.note_join();
  step.receive(state_at(0.01, 41));
  ASSERT_TRUE(draw_if_wanted(step, 0));
  ProbeState state = state_at(0.01, 42);
  state.round_trip_p99_us = 70.0F;
  step.receive(state);
  ASSERT_TRUE(draw_if_wanted(step, 500 * kMs)) << "it looks the same, but for the numbers in the corner";
  step.receive(state_at(0.05, 43));
  ASSERT_FALSE(draw_if_wanted(step, 501 * kMs)) << "too soon";
  EXPECT_FALSE(step.take_unchanged_ack());
}

TEST_F(VisionStepTest, WithoutAHubThereIsAPictureButNoReport) {
  VisionStep step(settings());
  ASSERT_TRUE(step.wants_picture(0, screen_));
  const auto shown = step.compose(0);
  EXPECT_FALSE(shown.probe);
  EXPECT_NE(shown.hud.find("waiting"), std::string::npos);
  EXPECT_FALSE(step.end_frame(0, kMs, screen_));
}

TEST_F(VisionStepTest, HudNeverContradictsThePictureAboutContact) {
  VisionStep step(settings());
  ProbeState state = state_at(0.01, 1);
  step.receive(state);
  ASSERT_TRUE(draw_if_wanted(step, 0));
  state.contact = true;
  state.object = 0;
  state.force_n = {0.0, 0.0, 1.25};
  step.receive(state);
  ASSERT_TRUE(step.wants_picture(11 * kMs, screen_));
  const std::string hud = step.compose(11 * kMs).hud;
  EXPECT_NE(hud.find("touching"), std::string::npos) << hud;
  EXPECT_NE(hud.find("1.25 N"), std::string::npos) << hud;
}

TEST_F(VisionStepTest, HudFollowsButSlowly) {
  VisionStep step(settings());
  ProbeState state = state_at(0.01, 1);
  step.receive(state);
  ASSERT_TRUE(draw_if_wanted(step, 0));
  int pictures = 0;
  for (int ms = 1; ms <= 4000; ++ms) {
    state.round_trip_p99_us = static_cast<float>(10 + ms);  // a new number each time
    step.receive(state);
    pictures += draw_if_wanted(step, ms * kMs);
  }
  EXPECT_GE(pictures, 8);
  EXPECT_LE(pictures, 11);
  EXPECT_NE(step.compose(5000 * kMs).hud.find("4010"), std::string::npos);
}

// The force bar shows the newest state; in a picture that a person looks at for long, the number must show the same force.
TEST_F(VisionStepTest, TheTextsOfAPictureThatStaysAreOfTheNewestState) {
  VisionStep step(settings());
  ProbeState state = state_at(0.01, 1);
  state.contact = true;
  state.force_n = {0.0, 0.0, 0.68};
  step.receive(state);
  ASSERT_TRUE(draw_if_wanted(step, 0));
  state.force_n = {0.0, 0.0, 0.72};
  step.receive(state);
  EXPECT_NE(step.compose(50 * kMs).hud.find("0.68 N"), std::string::npos) << "later, so that it can be read";
  const VisionStep::Texts texts = step.compose_texts(51 * kMs);
  EXPECT_NE(texts.hud.find("0.72 N"), std::string::npos) << texts.hud;
  EXPECT_EQ(texts.help, keys_help());
  EXPECT_EQ(step.compose(52 * kMs).hud, texts.hud);
}

TEST_F(VisionStepTest, WhatIsDrawnOnTheSceneCallsForAPictureAndLeavesTheSceneAtRest) {
  VisionStep step(settings());
  step.receive(state_at(0.0, 1));
  ASSERT_TRUE(draw_if_wanted(step, 0));
  EXPECT_FALSE(draw_if_wanted(step, 200 * kMs));
  EXPECT_TRUE(step.is_scene_at_rest(200 * kMs));
  step.set_annotations("1 stroke");
  EXPECT_TRUE(step.is_scene_at_rest(200 * kMs));
  ASSERT_TRUE(step.wants_picture(200 * kMs, screen_));
  EXPECT_NE(step.compose(200 * kMs).hud.find("1 stroke"), std::string::npos);
  step.end_frame(200 * kMs, 205 * kMs, screen_);
  EXPECT_FALSE(draw_if_wanted(step, 300 * kMs));
}

// A stroke is placed in the scene with this pose, so that a dial that turns meanwhile does not distort it.
TEST_F(VisionStepTest, FindsTheScenePoseWithWhichTheForcesOfAStateWereComputed) {
  VisionStep step(settings());
  step.receive(state_at(0.0, 1, 0));
  const Pose before = step.scene_pose();
  const std::uint32_t revision = step.view_transform().revision();
  step.turn_dials({0.0, 30.0, 0.0});
  EXPECT_TRUE(step.find_scene_pose(revision).isApprox(before, 1e-6));
  EXPECT_TRUE(step.find_scene_pose(revision + 1).isApprox(step.scene_pose(), 1e-6));
  EXPECT_FALSE(step.scene_pose().isApprox(before, 1e-6));
  EXPECT_TRUE(step.find_scene_pose(revision + 7).isApprox(step.scene_pose(), 1e-12)) << "the revision of another node";
}

}  // namespace
}  // namespace hapton
