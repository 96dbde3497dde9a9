#include "io_node/view_relay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/io_node/servo_fixture.h"

namespace hapton {
namespace {

TEST_F(Servos, ConfirmsTheViewThatTheForcesAreComputedWith) {
  make();
  join(kVision, NodeRole::vision);
  say(kVision, ViewTransform{.revision = 3});
  run(100);
  EXPECT_EQ(probes.back().view_revision, 3U) << "no haptics node: the view that the next one will get";
  join(kHaptics, NodeRole::haptics);
  run(100);
  EXPECT_EQ(probes.back().view_revision, 3U);
  takes_views = false;
  force_reply.view_revision = 3;
  views.clear();
  say(kVision, ViewTransform{.revision = 4});
  run(100);
  ASSERT_FALSE(views.empty());
  EXPECT_EQ(views.back().revision, 4U);
  EXPECT_EQ(probes.back().view_revision, 3U) << "relayed, and not in use";
  force_reply.view_revision = 4;
  run(20);
  EXPECT_EQ(probes.back().view_revision, 4U);
}

TEST_F(Servos, AHapticsNodeThatDiedLosesNothingAndItsSuccessorGetsTheView) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  ViewTransform view;
  view.revision = 4;
  view.X_WS[3] = 0.5F;
  say(kVision, view);
  run(300);
  ASSERT_FALSE(views.empty());
  EXPECT_EQ(views.front().X_WS[3], 0.5F);
  EXPECT_EQ(probes.back().view_revision, 4U);
  // Killed: neither replies nor heartbeats; then another at another port.
  reply_delay_ns = -1;
  sequences.erase(kHaptics);
  run(1200);
  EXPECT_EQ(stats().hub.timeouts, 1U);
  views.clear();
  reply_delay_ns = 100 * kUs;
  sequences[kHaptics] = 0;
  endpoint.arrive(clock.now_ns(), at(kHaptics), {{0, 2000, 1, 0}, Hello{NodeRole::haptics}});
  servo->step();
  EXPECT_EQ(views.size(), 1U);
  run(300);
  servo->finish();
  EXPECT_EQ(stats().responses.lost, 0U);
  EXPECT_GT(stats().responses.excused, 1000U);
}

// The haptics node dies in contact, a vision node joins with this view, and the next haptics node comes.
struct ContactAcrossAView : Servos {
  bool resumes_after(const ViewTransform& view) {
    make();
    join(kHaptics, NodeRole::haptics);
    run(100);
    reply_delay_ns = -1;
    sequences.erase(kHaptics);
    run(10);
    join(kVision, NodeRole::vision);
    say(kVision, view);
    run(10);
    states.clear();
    sequences[kHaptics] = 0;
    endpoint.arrive(clock.now_ns(), at(kHaptics), {{0, 2000, 1, 0}, Hello{NodeRole::haptics}});
    run(5);
    return std::any_of(states.begin(), states.end(), [](const DeviceState& state) { return state.is_resumed; });
  }
};

TEST_F(ContactAcrossAView, IsResumedWhereTheViewMovesNothing) {
  ViewTransform view;
  view.revision = 1;
  EXPECT_TRUE(resumes_after(view));
}

TEST_F(ContactAcrossAView, IsForgottenWhereTheSceneMoves) {
  ViewTransform view;
  view.revision = 1;
  view.X_WS[3] = 0.001F;
  EXPECT_FALSE(resumes_after(view));
}

}  // namespace
}  // namespace hapton
