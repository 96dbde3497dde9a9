#include "io_node/vision_feed.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/io_node/scripted_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::uint64_t kFeedSession = 77;

// A hub with one vision node, which has joined.
struct Feed : testing::Test {
  SimulatedClock clock{1'000'000'000};
  ScriptedEndpoint endpoint{clock};
  HubPeers peers{endpoint, clock, kFeedSession, 1000.0};
  std::unique_ptr<ServoStats> stats = std::make_unique<ServoStats>();
  VisionFeed feed{peers, *stats, 1000.0, 5};  // ignores buttons 5, which run_cycle_at() holds down: they must not hasten states
  ProbeHistory history;
  DeviceSide side;
  DeviceCycle cycle;
  std::vector<ProbeState> received;
  std::size_t vision_slot = 0;

  void SetUp() override {
    endpoint.on_send = [this](const Address&, const Datagram& datagram) {
      if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) received.push_back(*probe);
    };
    stats->start_ns = clock.now_ns();
    feed.start(clock.now_ns());
    endpoint.arrive(clock.now_ns(), {{9}, 2}, {{0, 1002, 1, clock.now_ns()}, Hello{NodeRole::vision}});
    Datagram datagram;
    const PeerEvent joined = peers.receive(datagram, clock.now_ns());
    ASSERT_EQ(joined.kind, PeerEvent::Kind::joined);
    vision_slot = joined.peer;
    feed.on_joined(vision_slot);
  }
  void run_cycle_at(double x_m) {
    clock.advance_ns(kMs);
    ++cycle.number;
    cycle.sample.time_ns = clock.now_ns();
    cycle.sample.p_WD = Vec3(x_m, 0, 0);
    cycle.sample.buttons = 5;
    history.note_sample(cycle.number, cycle.sample);
    side.written.force_n = Vec3(0, 0, x_m);
    side.has_timed_out = true;
    feed.send(history, side, cycle, 3, ProbeStatus::ok, clock.now_ns());
  }
  FrameAck ack_of_newest() const { return {received.back().sample, received.back().sample_time_ns, 60.0F}; }
};

TEST_F(Feed, SendsTheProbeAtOnceAndTheNextOneWhenItIsDrawn) {
  run_cycle_at(0.01);
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0].p_WD.x(), 0.01);
  EXPECT_EQ(received[0].force_n.z(), 0.01);
  EXPECT_EQ(received[0].buttons, 5U);
  EXPECT_EQ(received[0].view_revision, 3U);
  run_cycle_at(0.02);
  EXPECT_EQ(received.size(), 1U);  // the vision node has not drawn yet
  feed.on_frame_ack({}, ack_of_newest(), vision_slot, cycle.number, clock.now_ns());
  for (int n = 0; n < 20; ++n) run_cycle_at(0.03);
  EXPECT_GT(received.size(), 1U);
  EXPECT_EQ(stats->probe_states_sent, received.size());
  EXPECT_EQ(stats->drawn, 1U);
  EXPECT_EQ(stats->frame_rate_hz, 60.0);
}

TEST_F(Feed, SendsTheForceLimit) {
  feed.set_force_limit(7.5);
  run_cycle_at(0.01);
  EXPECT_EQ(received.back().force_limit_n, 7.5F);
}

TEST_F(Feed, SendsHowMuchOfTheEnergyBudgetIsSpent) {
  side.governor.energy_most_j = 0.2;
  side.governor.energy_spent_j = 0.0679;
  run_cycle_at(0.01);
  EXPECT_EQ(received.back().energy_percent, 34U);
  feed.on_frame_ack({}, ack_of_newest(), vision_slot, cycle.number, clock.now_ns());
  side.governor.energy_spent_j = -0.05;  // the device has taken in more energy than it gave
  for (int n = 0; n < 20; ++n) run_cycle_at(0.02);
  EXPECT_EQ(received.back().energy_percent, 0U);
}

TEST_F(Feed, SendsTheTorqueOnTheMotors) {
  side.written.torque_nm = Vec3(0.01, -0.02, 0.03);
  run_cycle_at(0.01);
  EXPECT_EQ(received.back().torque_nm, side.written.torque_nm);
}

// Replies that come too late give no force. The median, which includes the good time before, does not show that.
TEST_F(Feed, SendsTheRoundTripOfTheHapticsNodeAndTheNewestWhereRepliesAreLate) {
  const auto sent_round_trip_us = [&] {
    feed.refresh_statistics(cycle.number, clock.now_ns());
    clock.advance_ns(VisionPace::kRepeatNs);
    run_cycle_at(0.01);
    return received.back().round_trip_p50_us;
  };
  for (int n = 0; n < 100; ++n) stats->round_trip.record(n < 60 ? 100 * kUs : 400 * kUs);
  EXPECT_EQ(sent_round_trip_us(), 0.0F) << "no haptics node has joined";
  endpoint.arrive(clock.now_ns(), {{9}, 1}, {{0, 1001, 1, clock.now_ns()}, Hello{NodeRole::haptics}});
  Datagram datagram;
  ASSERT_EQ(peers.receive(datagram, clock.now_ns()).kind, PeerEvent::Kind::joined);
  EXPECT_NEAR(sent_round_trip_us(), 100.0, 2.0);
  EXPECT_NEAR(received.back().round_trip_p99_us, 400.0, 8.0);
  stats->newest_round_trip_s = 0.9e-9 * static_cast<double>(kCommandTimeoutNs);
  EXPECT_NEAR(sent_round_trip_us(), 100.0, 2.0);
  stats->newest_round_trip_s = 2e-9 * static_cast<double>(kCommandTimeoutNs);
  EXPECT_NEAR(sent_round_trip_us(), 2e-3 * static_cast<double>(kCommandTimeoutNs), 1.0);
}

TEST_F(Feed, AcknowledgementsOfFramesThatWereNeverSentAreIgnored) {
  run_cycle_at(0.01);
  for (const FrameAck& forged : {FrameAck{0, clock.now_ns(), 60.0F}, FrameAck{99, clock.now_ns(), 60.0F},
                                 FrameAck{1, clock.now_ns() + kMs, 60.0F}, FrameAck{1, stats->start_ns - kMs, 60.0F}}) {
    feed.on_frame_ack({}, forged, vision_slot, cycle.number, clock.now_ns());
  }
  EXPECT_EQ(stats->drawn, 0U);
}

// `hapton dds` is such a node: it passes states on. Its messages are not frames, and do not count as frames.
TEST_F(Feed, ANodeThatPassesStatesOnDrawsNothing) {
  for (int n = 0; n < 10; ++n) {
    run_cycle_at(0.01);
    FrameAck ack = ack_of_newest();
    ack.every_sample = true;
    feed.on_frame_ack({}, ack, vision_slot, cycle.number, clock.now_ns());
  }
  EXPECT_EQ(received.size(), 10U);
  EXPECT_EQ(stats->drawn, 0U);
  EXPECT_EQ(stats->frame_rate_hz, 0.0);
}

TEST_F(Feed, ReportsTheRateOfTheSamplesSinceTheLastStatistics) {
  for (int n = 0; n < 500; ++n) {
    run_cycle_at(0.001 * n);
    if (!received.empty()) feed.on_frame_ack({}, ack_of_newest(), vision_slot, cycle.number, clock.now_ns());
  }
  feed.refresh_statistics(cycle.number, clock.now_ns());
  for (int n = 0; n < 200; ++n) run_cycle_at(0.5 + 0.001 * n);
  EXPECT_NEAR(static_cast<double>(received.back().servo_rate_hz), 1000.0, 1.0);
}

}  // namespace
}  // namespace hapton
