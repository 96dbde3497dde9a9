#include "io_node/view_relay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, ConfirmsTheViewThatTheForcesAreComputedWith) {
  make();
  join(kVision, NodeRole::vision);
  say(kVision, ViewTransform{.revision = 3});
  run(100);
  EXPECT_EQ(probes.back().view_revision, 3U) << "no haptics node: the view that the next one will get";
  join(kHaptics, NodeRole::haptics);
  run(100);
  EXPECT_EQ(probes.back().view_revision, 3U);
  replies_name_newest_view = false;
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

TEST_F(NetworkLoops, AHapticsNodeThatDiedLosesNothingAndItsSuccessorGetsTheView) {
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
  // The haptics node is killed: it sends neither replies nor heartbeats. Then another process joins from the same address.
  reply_delay_ns = -1;
  sequences.erase(kHaptics);
  run(1200);
  EXPECT_EQ(stats().hub.timeouts, 1U);
  views.clear();
  reply_delay_ns = 100 * kUs;
  sequences[kHaptics] = 0;
  endpoint.arrive(clock.now_ns(), at(kHaptics), {{0, 2000, 1, 0}, Hello{NodeRole::haptics}});
  network->step();
  EXPECT_EQ(views.size(), 1U);
  run(300);
  network->finish();
  EXPECT_EQ(stats().responses.lost, 0U);
  EXPECT_GT(stats().responses.excused, 1000U);
}

// Whether contact is resumed if the haptics node dies in contact, a vision node joins with this view, and the next haptics node joins.
struct ContactAcrossAView : NetworkLoops {
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

// Two vision nodes. The second one joins with the pose that the scene had at that node's start.
struct TwoViewers : NetworkLoops {
  static constexpr std::uint16_t kSecondVision = 4;
  ViewTransform turned_view{.revision = 41};
  std::vector<ViewTransform> views_to_haptics, views_to_first, views_to_second;

  void SetUp() override {
    NetworkLoops::SetUp();
    turned_view.X_WS[3] = 0.05F;
    endpoint.on_send = [this](const Address& to, const Datagram& datagram) {
      receive(to, datagram);
      const auto* view = std::get_if<ViewTransform>(&datagram.message);
      if (view != nullptr) (to == at(kHaptics) ? views_to_haptics : to == at(kVision) ? views_to_first : views_to_second).push_back(*view);
    };
    make();
    roles[kSecondVision] = NodeRole::vision;
    join(kHaptics, NodeRole::haptics);
    join(kVision, NodeRole::vision);
    run(10);
    say(kVision, turned_view);
    run(10);
    forget_views();
  }
  void forget_views() {
    views_to_haptics.clear();
    views_to_first.clear();
    views_to_second.clear();
  }
};

TEST_F(TwoViewers, ANodeThatJoinsGetsTheViewInUseAndDoesNotTurnTheScene) {
  join(kSecondVision, NodeRole::vision);
  run(2);
  ASSERT_FALSE(views_to_second.empty());
  EXPECT_EQ(views_to_second.back().revision, 41U);
  EXPECT_EQ(views_to_second.back().X_WS, turned_view.X_WS);
  for (const std::uint32_t revision : {1U, 41U}) {
    forget_views();
    say(kSecondVision, ViewTransform{.revision = revision});
    run(300);
    ASSERT_FALSE(views_to_haptics.empty()) << "it is repeated";
    for (const ViewTransform& view : views_to_haptics) EXPECT_EQ(view.X_WS, turned_view.X_WS) << revision;
    ASSERT_FALSE(views_to_second.empty());
    EXPECT_EQ(views_to_second.front().revision, 41U) << "instead of its own";
    EXPECT_TRUE(views_to_first.empty());
  }
}

TEST_F(TwoViewers, EitherTurnsTheSceneOnceItKnowsTheView) {
  join(kSecondVision, NodeRole::vision);
  run(2);
  forget_views();
  say(kSecondVision, ViewTransform{.revision = 42});
  run(2);
  ASSERT_EQ(views_to_haptics.size(), 1U);
  EXPECT_EQ(views_to_haptics[0].revision, 42U);
  ASSERT_EQ(views_to_first.size(), 1U) << "which shows it";
  EXPECT_EQ(views_to_first[0].revision, 42U);
  forget_views();
  say(kVision, ViewTransform{.revision = 42, .X_WS = turned_view.X_WS});  // both at once: the first one counts
  run(2);
  EXPECT_TRUE(views_to_haptics.empty());
  ASSERT_EQ(views_to_first.size(), 1U);
  EXPECT_EQ(views_to_first[0].X_WS, ViewTransform().X_WS);
}

TEST_F(TwoViewers, AfterTheFirstHasLeftTheNextSetsAnyView) {
  say(kVision, Bye{});
  sequences.erase(kVision);
  join(kSecondVision, NodeRole::vision);
  run(2);
  forget_views();
  say(kSecondVision, ViewTransform{.revision = 3});
  run(2);
  ASSERT_EQ(views_to_haptics.size(), 1U);
  EXPECT_EQ(views_to_haptics[0].revision, 3U);
}

// The hub was restarted, and no vision node has joined yet.
TEST_F(NetworkLoops, AHubWithoutAViewTakesThatOfTheHapticsNode) {
  make();
  join(kHaptics, NodeRole::haptics);
  HapticsSetup setup;
  setup.view_revision = 7;
  setup.X_WS[3] = 0.05F;
  say(kHaptics, setup);
  run(10);
  views.clear();
  join(kVision, NodeRole::vision);
  run(5);
  ASSERT_FALSE(views.empty());
  EXPECT_EQ(views.back().revision, 7U);
  EXPECT_EQ(views.back().X_WS, setup.X_WS);
  setup.view_revision = 8;
  setup.X_WS[3] = 0.0F;
  views.clear();
  say(kHaptics, setup);
  run(300);
  ASSERT_FALSE(views.empty());
  EXPECT_EQ(views.back().revision, 7U) << "the hub has a view now";
}

}  // namespace
}  // namespace hapton
