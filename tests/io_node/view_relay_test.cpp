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
  static constexpr std::uint16_t kSecond = 4;
  ViewTransform turned{.revision = 41};
  std::vector<ViewTransform> of_haptics, of_first, of_second;

  void SetUp() override {
    NetworkLoops::SetUp();
    turned.X_WS[3] = 0.05F;
    endpoint.on_send = [this](const Address& to, const Datagram& datagram) {
      receive(to, datagram);
      const auto* view = std::get_if<ViewTransform>(&datagram.message);
      if (view != nullptr) (to == at(kHaptics) ? of_haptics : to == at(kVision) ? of_first : of_second).push_back(*view);
    };
    make();
    roles[kSecond] = NodeRole::vision;
    join(kHaptics, NodeRole::haptics);
    join(kVision, NodeRole::vision);
    run(10);
    say(kVision, turned);
    run(10);
    forget();
  }
  void forget() {
    of_haptics.clear();
    of_first.clear();
    of_second.clear();
  }
};

TEST_F(TwoViewers, ANodeThatJoinsGetsTheViewInUseAndDoesNotTurnTheScene) {
  join(kSecond, NodeRole::vision);
  run(2);
  ASSERT_FALSE(of_second.empty());
  EXPECT_EQ(of_second.back().revision, 41U);
  EXPECT_EQ(of_second.back().X_WS, turned.X_WS);
  for (const std::uint32_t revision : {1U, 41U}) {
    forget();
    say(kSecond, ViewTransform{.revision = revision});
    run(300);
    ASSERT_FALSE(of_haptics.empty()) << "it is repeated";
    for (const ViewTransform& view : of_haptics) EXPECT_EQ(view.X_WS, turned.X_WS) << revision;
    ASSERT_FALSE(of_second.empty());
    EXPECT_EQ(of_second.front().revision, 41U) << "instead of its own";
    EXPECT_TRUE(of_first.empty());
  }
}

TEST_F(TwoViewers, EitherTurnsTheSceneOnceItKnowsTheView) {
  join(kSecond, NodeRole::vision);
  run(2);
  forget();
  say(kSecond, ViewTransform{.revision = 42});
  run(2);
  ASSERT_EQ(of_haptics.size(), 1U);
  EXPECT_EQ(of_haptics[0].revision, 42U);
  ASSERT_EQ(of_first.size(), 1U) << "which shows it";
  EXPECT_EQ(of_first[0].revision, 42U);
  forget();
  say(kVision, ViewTransform{.revision = 42, .X_WS = turned.X_WS});  // both at once: the first one counts
  run(2);
  EXPECT_TRUE(of_haptics.empty());
  ASSERT_EQ(of_first.size(), 1U);
  EXPECT_EQ(of_first[0].X_WS, ViewTransform().X_WS);
}

TEST_F(TwoViewers, AfterTheFirstHasLeftTheNextSetsAny) {
  say(kVision, Bye{});
  sequences.erase(kVision);
  join(kSecond, NodeRole::vision);
  run(2);
  forget();
  say(kSecond, ViewTransform{.revision = 3});
  run(2);
  ASSERT_EQ(of_haptics.size(), 1U);
  EXPECT_EQ(of_haptics[0].revision, 3U);
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
  EXPECT_EQ(views.back().revision, 7U) << "it has one now";
}

}  // namespace
}  // namespace hapton
