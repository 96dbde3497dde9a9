// The pose of the scene that a vision node sends, and the pose from another node that it shows.
#include <gtest/gtest.h>

#include "tests/vision_node/vision_step_fixture.h"
#include "vision_node/knob_box.h"

namespace hapton {
namespace {

TEST_F(VisionStepTest, SendsTheTransformThatItDraws) {
  VisionStepSettings turned = settings();
  turned.dials.turn(1, 30.0);
  VisionStep step(turned);
  step.note_join();
  EXPECT_TRUE(take_all<ViewTransform>(step, 0).empty()) << "the hub may have a view, which comes before its first state";
  step.receive(state_at(0.0, 1, 0));
  auto sent = take_all<ViewTransform>(step, 0);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].X_WS, to_twelve_floats(step.compose(0).X_WS));
  step.receive(state_at(0.0, 1, sent[0].revision));
  take_all<ViewTransform>(step, kMs);
  WindowEvent event;
  event.key = 'x';
  step.handle(event, screen_);
  sent = take_all<ViewTransform>(step, 2 * kMs);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].X_WS, to_twelve_floats(step.compose(2 * kMs).X_WS));
}

TEST_F(VisionStepTest, ATransformThatGotLostIsSentAgain) {
  VisionStep step(settings());
  step.note_join();
  step.receive(state_at(0.0, 1, 0));
  ASSERT_EQ(take_all<ViewTransform>(step, 0).size(), 1u);
  std::size_t again = 0;
  for (int ms = 1; ms < 500; ++ms) {
    step.receive(state_at(0.0, static_cast<std::uint64_t>(ms), 0));
    again += take_all<ViewTransform>(step, ms * kMs).size();
  }
  EXPECT_GE(again, 3u);
  step.receive(state_at(0.0, 600, step.view_transform().revision()));
  EXPECT_TRUE(take_all<ViewTransform>(step, 1000 * kMs).empty());
}

ViewTransform view_of(std::uint32_t revision, const Vec3& degrees) {
  return {.revision = revision, .X_WS = to_twelve_floats(Dials{degrees}.compute_pose(Vec3::Zero()))};
}

// The hub sends its view transform to a joining node at once, and repeats it: the node waits for it, even if messages were lost.
TEST_F(VisionStepTest, WaitsForTheViewThatTheHubHas) {
  VisionStep step(settings());
  step.note_join();
  step.receive(state_at(0.0, 1, 41));
  EXPECT_TRUE(take_all<ViewTransform>(step, 0).empty()) << "the hub has a view, but its message was lost";
  EXPECT_TRUE(take_all<ViewTransform>(step, 250 * kMs).empty());
  step.receive(view_of(41, Vec3(0, 80, -15)));
  EXPECT_TRUE(take_all<ViewTransform>(step, 300 * kMs).empty());
  EXPECT_EQ(step.interaction().dials().degrees, Vec3(0, 80, -15));
  // A hub of an older version sends no view transform.
  VisionStep old(settings());
  old.note_join();
  old.receive(state_at(0.0, 1, 41));
  EXPECT_TRUE(take_all<ViewTransform>(old, 0).empty());
  EXPECT_EQ(take_all<ViewTransform>(old, 1000 * kMs).size(), 1u);
}

// The hub and the haptics node were restarted, and a program has set the pose since.
TEST_F(VisionStepTest, AfterARestartTheHubsViewCountsWhateverItsNumber) {
  VisionStep step(settings());
  step.note_join();
  step.receive(view_of(57, Vec3(0, 80, -15)));
  step.note_join();
  step.receive(view_of(1, Vec3(10, 0, 0)));
  step.receive(state_at(0.0, 1, 1));
  EXPECT_TRUE(take_all<ViewTransform>(step, 0).empty());
  EXPECT_EQ(step.interaction().dials().degrees, Vec3(10, 0, 0));
  step.turn_dials(Vec3(5, 0, 0));
  const auto sent = take_all<ViewTransform>(step, kMs);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].revision, 2u);
}

TEST_F(VisionStepTest, ShowsTheViewThatTheHubHasAndGoesOnFromThere) {
  VisionStep step(settings());
  step.note_join();
  step.receive(view_of(41, Vec3(0, 80, -15)));
  step.receive(state_at(0.0, 1, 41));
  EXPECT_TRUE(take_all<ViewTransform>(step, 0).empty()) << "it does not turn the scene by joining";
  EXPECT_EQ(step.interaction().dials().degrees, Vec3(0, 80, -15));
  EXPECT_EQ(to_twelve_floats(step.compose(0).X_WS), view_of(41, Vec3(0, 80, -15)).X_WS);
  step.turn_dials(Vec3(0, 0, 5));
  const auto sent = take_all<ViewTransform>(step, kMs);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].revision, 42u);
  EXPECT_EQ(sent[0].X_WS, view_of(42, Vec3(0, 80, -10)).X_WS);
  // Another node turns the scene; an older view transform does not count.
  step.receive(view_of(43, Vec3(10, 0, 0)));
  step.receive(view_of(41, Vec3(0, 80, -15)));
  EXPECT_EQ(step.interaction().dials().degrees, Vec3(10, 0, 0));
  step.receive(state_at(0.0, 2, 42));  // computed before that turn
  EXPECT_TRUE(take_all<ViewTransform>(step, 1000 * kMs).empty()) << "it is not its own to repeat";
}

// A program may also shift the scene, which the dials cannot.
TEST_F(VisionStepTest, ShowsASceneThatAProgramHasMoved) {
  VisionStep step(settings());
  step.note_join();
  ViewTransform moved = view_of(7, Vec3(0, 0, 30));
  moved.X_WS[3] += 0.02F;
  step.receive(moved);
  step.receive(state_at(0.0, 1, 7));
  EXPECT_EQ(to_twelve_floats(step.compose(0).X_WS), moved.X_WS);
  step.turn_dials(Vec3(0, 0, 5));
  const auto sent = take_all<ViewTransform>(step, kMs);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].revision, 8u);
  EXPECT_LT((from_twelve_floats(sent[0].X_WS).translation() - from_twelve_floats(moved.X_WS).translation()).norm(), 0.01) << "from there";
}

TEST_F(VisionStepTest, DialsOfTheOptionsGoToTheHub) {
  VisionStepSettings turned = settings();
  turned.dials.turn(1, 30.0);
  VisionStep step(turned);
  step.note_join();
  step.receive(view_of(41, Vec3(0, 90, 0)));
  step.receive(state_at(0.0, 1, 41));
  const auto sent = take_all<ViewTransform>(step, 0);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].revision, 42u);
  EXPECT_EQ(sent[0].X_WS, view_of(42, Vec3(0, 30, 0)).X_WS);
  step.receive(view_of(43, Vec3(10, 0, 0)));
  EXPECT_EQ(step.interaction().dials().degrees, Vec3(10, 0, 0)) << "it was sent: now others count, too";
}

// A node that joins a hub again must not turn the scene while a hand touches it.
TEST_F(VisionStepTest, AfterEachJoinItWaitsAnewForTheViewThatTheHubHas) {
  VisionStep step(settings());
  step.note_join();
  step.receive(state_at(0.0, 1, 41));
  EXPECT_TRUE(take_all<ViewTransform>(step, 0).empty());
  ASSERT_EQ(take_all<ViewTransform>(step, 1000 * kMs).size(), 1u) << "a hub that sends none";
  step.receive(state_at(0.0, 2, 42));
  // The hub was restarted, and somebody has turned the scene since.
  step.note_join();
  EXPECT_TRUE(take_all<ViewTransform>(step, 2000 * kMs).empty());
  step.receive(state_at(0.0, 1, 3));
  EXPECT_TRUE(take_all<ViewTransform>(step, 2001 * kMs).empty()) << "the hub has a view, but its message was lost";
  EXPECT_TRUE(take_all<ViewTransform>(step, 2500 * kMs).empty());
  step.receive(view_of(3, Vec3(0, 80, -15)));
  EXPECT_EQ(step.interaction().dials().degrees, Vec3(0, 80, -15)) << "though its own number was larger";
  EXPECT_TRUE(take_all<ViewTransform>(step, 2501 * kMs).empty());
}

TEST_F(VisionStepTest, TheViewOfAnEarlierSessionIsNotThatOfTheHub) {
  VisionStep step(settings());
  step.note_join();
  step.receive(view_of(57, Vec3(0, 80, -15)));
  step.receive(state_at(0.0, 1, 57));
  EXPECT_TRUE(take_all<ViewTransform>(step, 0).empty());
  step.note_join();
  step.receive(state_at(0.0, 1, 1));
  EXPECT_TRUE(take_all<ViewTransform>(step, kMs).empty());
}

}  // namespace
}  // namespace hapton
