#include "vision_node/other_hand.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "tests/support/log_of.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// The other hand and its hub run alternately, once in each millisecond.
struct OtherHandTest : testing::Test {
  OtherHandTest() { start_hub(1); }
  void start_hub(std::uint64_t session) { hub.emplace(*hub_endpoint, clock, session, 1000.0); }

  void run(int milliseconds, const Pose& X_WS) {
    for (int n = 0; n < milliseconds; ++n) {
      clock.advance_ns(kMs);
      take_messages();
      hand.update(X_WS, clock.now_ns());
      take_messages();
    }
  }
  void take_messages() {
    if (!hub) return;
    Datagram datagram;
    std::uint64_t before = 0;
    do {
      before = hub->counts().received;
      if (hub->receive(datagram, 0).kind != PeerEvent::Kind::message) continue;
      if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) views.push_back(*view);
      if (const auto* ack = std::get_if<FrameAck>(&datagram.message)) acks.push_back(*ack);
    } while (hub->counts().received != before);
  }
  void send(const Message& message) { ASSERT_EQ(hub->send_to_role(NodeRole::vision, message), 1U); }
  bool wants_picture() { return hand.wants_picture(sizes, screen, kPicture); }

  static constexpr PictureSize kPicture{640, 720};
  static constexpr double kMaxRateHz = 50.0;
  SimulatedClock clock;
  MemoryNetwork network{clock};
  std::unique_ptr<Endpoint> hub_endpoint = *network.open(memory_address(1, 4950));
  std::unique_ptr<Endpoint> endpoint = *network.open(memory_address(2, 0));
  std::optional<HubPeers> hub;
  HubClient client{*endpoint, clock, NodeRole::vision, hub_endpoint->local_address()};
  OtherHand hand{client, Quat::Identity(), kMaxRateHz};
  Framing framing = frame_sphere(Vec3::Zero(), 0.12, 0.063);
  StereoScreen screen = compute_screen(framing, kPicture);
  ProbeSizes sizes = scale_probe(framing);
  const Pose X_WS_turned = Dials{Vec3(0.0, 30.0, 0.0)}.compute_pose(Vec3::Zero());
  std::vector<ViewTransform> views;
  std::vector<FrameAck> acks;
};

TEST_F(OtherHandTest, ItsHubGetsThePoseOfTheSceneUntilItHasIt) {
  run(5, X_WS_turned);
  ASSERT_EQ(client.state(), JoinState::joined);
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].X_WS, to_twelve_floats(X_WS_turned));
  send(ProbeState{.sample = 1});  // names no view: the view was lost
  run(60, X_WS_turned);
  EXPECT_EQ(views.size(), 2U);
  send(ProbeState{.sample = 2, .view_revision = views.back().revision});
  run(200, X_WS_turned);
  EXPECT_EQ(views.size(), 2U);
  run(1, Pose::Identity());
  ASSERT_EQ(views.size(), 3U);
  EXPECT_EQ(views.back().X_WS, to_twelve_floats(Pose::Identity()));
}

TEST_F(OtherHandTest, ItsPosesCountOnFromAViewOfAnotherNode) {
  run(5, X_WS_turned);
  ASSERT_EQ(views.size(), 1U);
  send(ViewTransform{.revision = 9});
  run(1, X_WS_turned);
  run(1, Pose::Identity());
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views.back().revision, 10U) << "the hub would ignore a smaller one";
}

TEST_F(OtherHandTest, APoseThatItsHubRejectsIsNotRepeated) {
  run(5, X_WS_turned);
  ASSERT_EQ(views.size(), 1U);
  const std::string log = log_of([&] {
    send(ViewRejected{views[0].revision});
    send(ProbeState{.sample = 1});
    run(200, X_WS_turned);
  });
  EXPECT_EQ(views.size(), 1U);
  EXPECT_NE(log.find("rejected view transform"), std::string::npos) << log;
}

TEST_F(OtherHandTest, AHubThatIsBackGetsThePoseAgain) {
  run(5, X_WS_turned);
  ASSERT_EQ(views.size(), 1U);
  const std::string log = log_of([&] {
    hub.reset();
    run(5, X_WS_turned);
    start_hub(2);
    run(150, X_WS_turned);
  });
  EXPECT_NE(log.find("the other hand's hub has ended its session"), std::string::npos) << log;
  EXPECT_NE(log.find("joined the other hand's hub"), std::string::npos) << log;
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(views.back().X_WS, to_twelve_floats(X_WS_turned));
}

// The hand must not go back to where it was before.
TEST_F(OtherHandTest, AStateThatANewerOneOvertookIsNotShown) {
  run(5, X_WS_turned);
  network.set_impairments({.delay_ns = 3 * kMs});
  send(ProbeState{.sample = 5, .p_WD = Vec3(0.01, 0.0, 0.0), .view_revision = 1});
  network.set_impairments({});
  send(ProbeState{.sample = 6, .p_WD = Vec3(0.02, 0.0, 0.0), .view_revision = 1});
  run(6, X_WS_turned);
  ASSERT_TRUE(hand.shown());
  EXPECT_NEAR(hand.shown()->p_WP.x(), 0.02, 1e-6);
}

TEST_F(OtherHandTest, WithoutALimitOfItsRateNoFrameWaits) {
  OtherHand unlimited{client, Quat::Identity(), 0.0};
  run(5, X_WS_turned);
  send(ProbeState{.sample = 5, .p_WD = Vec3(0.01, 0.0, 0.0), .view_revision = 1});
  clock.advance_ns(kMs);
  unlimited.update(X_WS_turned, clock.now_ns());
  unlimited.end_frame(clock.now_ns(), clock.now_ns() + kMs, 40.0, sizes, screen, kPicture);
  run(1, X_WS_turned);
  ASSERT_EQ(acks.size(), 1U);
  EXPECT_EQ(acks[0].held_ns, kMs);
  EXPECT_EQ(acks[0].rest_ns, 0U);
}

TEST_F(OtherHandTest, EachStateIsAcknowledgedOnce) {
  run(5, X_WS_turned);
  EXPECT_FALSE(hand.shown());
  EXPECT_FALSE(wants_picture()) << "nothing came";
  send(ProbeState{.sample = 5, .sample_time_ns = 77, .p_WD = Vec3(0.01, 0.0, 0.0), .view_revision = 1});
  run(1, X_WS_turned);
  ASSERT_TRUE(wants_picture());
  ASSERT_TRUE(hand.shown());
  EXPECT_NEAR(hand.shown()->p_WP.x(), 0.01, 1e-6);
  clock.advance_ns(2 * kMs);
  const std::int64_t start_ns = clock.now_ns();
  clock.advance_ns(8 * kMs);
  hand.end_frame(start_ns, clock.now_ns(), 40.0, sizes, screen, kPicture);
  run(1, X_WS_turned);
  ASSERT_EQ(acks.size(), 1U);
  EXPECT_EQ(acks[0].echo_sample, 5U);
  EXPECT_EQ(acks[0].echo_sample_time_ns, 77);
  EXPECT_EQ(acks[0].frame_rate_hz, 40.0F);
  EXPECT_EQ(acks[0].held_ns, 10 * kMs) << "from its arrival to the end of the frame";
  EXPECT_EQ(acks[0].rest_ns, 12 * kMs) << "from there until the next frame may begin";
  EXPECT_FALSE(acks[0].unchanged);
  // The hand is at the same place: it needs no picture, and a picture that is drawn for the other hub's hand is reported as unchanged.
  send(ProbeState{.sample = 6, .sample_time_ns = 78, .p_WD = Vec3(0.01, 0.0, 0.0), .view_revision = 1});
  run(1, X_WS_turned);
  EXPECT_FALSE(wants_picture());
  hand.end_frame(clock.now_ns(), clock.now_ns() + kMs, 40.0, sizes, screen, kPicture);
  run(1, X_WS_turned);
  ASSERT_EQ(acks.size(), 2U);
  EXPECT_EQ(acks[1].echo_sample, 6U);
  EXPECT_TRUE(acks[1].unchanged);
  EXPECT_FALSE(wants_picture());
}

// The first acknowledgement of a state may be lost, and the hub waits for one.
TEST_F(OtherHandTest, WhereNoNewerStateComesAFrameAcknowledgesAgain) {
  run(5, X_WS_turned);
  send(ProbeState{.sample = 5, .sample_time_ns = 77, .p_WD = Vec3(0.01, 0.0, 0.0), .view_revision = 1});
  run(1, X_WS_turned);
  ASSERT_TRUE(wants_picture());
  for (int frame = 0; frame < 10; ++frame) {
    hand.end_frame(clock.now_ns(), clock.now_ns(), 60.0, sizes, screen, kPicture);
    run(10, X_WS_turned);
  }
  ASSERT_EQ(acks.size(), 3U) << "at 0, 40 and 80 ms";
  EXPECT_FALSE(acks[0].unchanged);
  for (const std::size_t n : {1U, 2U}) {
    EXPECT_EQ(acks[n].echo_sample, 5U);
    EXPECT_EQ(acks[n].echo_sample_time_ns, 77);
    EXPECT_TRUE(acks[n].unchanged) << "no frame to measure";
    EXPECT_EQ(acks[n].held_ns, 0U);
  }
}

}  // namespace
}  // namespace hapton
