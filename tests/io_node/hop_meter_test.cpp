#include "io_node/hop_meter.h"

#include <gtest/gtest.h>

#include <limits>

#include "link/memory_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// A hub whose datagrams take given times, and a node whose clock is ahead by a given offset.
struct HopMeters : testing::Test {
  SimulatedClock clock{1'000'000'000};
  MemoryNetwork network{clock};
  std::unique_ptr<Endpoint> hub = *network.open(memory_address(1, 1));
  std::unique_ptr<Endpoint> node = *network.open(memory_address(2, 1));
  MeteredEndpoint metered{*hub, clock};
  HopMeter meter{metered};
  std::int64_t node_ahead_ns = 0;
  std::uint64_t sample = 0;

  // One sample and its force: 2 us to encode, out_ns on the wire, 7 us in the node, back_ns on the wire, 3 us to decode.
  void exchange(std::int64_t out_ns, std::int64_t back_ns) {
    const std::array<std::byte, 10> bytes = {};
    ForceCommand command;
    command.echo_sample = ++sample;
    command.echo_sample_time_ns = clock.now_ns();
    clock.advance_ns(2 * kUs);
    metered.send(node->local_address(), bytes);
    meter.on_state_sent(sample, command.echo_sample_time_ns);
    clock.advance_ns(out_ns + 7 * kUs);
    command.compute_ns = 7 * kUs;
    Header header;
    header.send_time_ns = clock.now_ns() + node_ahead_ns;
    node->send(hub->local_address(), bytes);
    clock.advance_ns(back_ns);
    std::array<std::byte, kMaxDatagramBytes> buffer;
    metered.receive(buffer, 0);
    clock.advance_ns(3 * kUs);
    meter.on_force(header, command, clock.now_ns());
    clock.advance_ns(kMs);
  }
  const HopStats& stats() { return meter.collect(clock.now_ns()); }
};

TEST_F(HopMeters, OnOneHostAreExactAndAddUpToTheRoundTrip) {
  meter.on_joined(HubPeers::kHapticsSlot, {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1}, 5});
  exchange(10 * kUs, 40 * kUs);
  EXPECT_EQ(stats().encode.max_ns(), 2 * kUs);
  EXPECT_EQ(stats().wire_out.max_ns(), 10 * kUs);
  EXPECT_EQ(stats().wire_back.max_ns(), 40 * kUs);
  EXPECT_EQ(stats().decode.max_ns(), 3 * kUs);
  EXPECT_TRUE(stats().is_one_clock);
  EXPECT_EQ(stats().link.datagrams_sent, 1U);
  EXPECT_EQ(stats().link.bytes_received, 10U);
}

TEST_F(HopMeters, BetweenHostsUseTheOffsetOfTheClocks) {
  meter.on_joined(HubPeers::kHapticsSlot, memory_address(2, 1));
  node_ahead_ns = -3'600'000'000'000;
  for (int n = 0; n < 20; ++n) exchange(30 * kUs, 30 * kUs);
  EXPECT_FALSE(stats().is_one_clock);
  ASSERT_TRUE(stats().is_offset_known);
  EXPECT_NEAR(static_cast<double>(stats().clock_offset_ns - node_ahead_ns), 0.0, 1.0);
  EXPECT_NEAR(static_cast<double>(stats().clock_error_ns), 30.0 * kUs, 2.0 * kUs);
  EXPECT_EQ(stats().wire_out.count(), 20U);
  // A queue on the return path lengthens the return path and nothing else.
  exchange(30 * kUs, 230 * kUs);
  EXPECT_NEAR(static_cast<double>(stats().wire_out.max_ns()), 30.0 * kUs, 2.0);
  EXPECT_NEAR(static_cast<double>(stats().wire_back.max_ns()), 230.0 * kUs, 2.0);
}

TEST_F(HopMeters, ForgetTheClockOfANodeThatWasReplaced) {
  meter.on_joined(HubPeers::kHapticsSlot, memory_address(2, 1));
  node_ahead_ns = 5'000'000'000;
  exchange(30 * kUs, 30 * kUs);
  meter.on_joined(HubPeers::kHapticsSlot, memory_address(3, 1));
  EXPECT_FALSE(stats().is_offset_known);
}

TEST_F(HopMeters, JitterIsTheDifferenceBetweenSuccessiveRoundTrips) {
  meter.on_joined(HubPeers::kHapticsSlot, memory_address(2, 1));
  exchange(10 * kUs, 10 * kUs);
  exchange(10 * kUs, 60 * kUs);
  exchange(10 * kUs, 60 * kUs);
  EXPECT_EQ(stats().jitter.count(), 2U);
  EXPECT_EQ(stats().jitter.max_ns(), 50 * kUs);
  EXPECT_EQ(stats().jitter.min_ns(), 0);
}

TEST_F(HopMeters, UnknownTimesAreLeftOut) {
  meter.on_joined(HubPeers::kHapticsSlot, memory_address(2, 1));
  for (const std::int64_t bad : {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    ForceCommand command;
    command.compute_ns = std::numeric_limits<std::uint32_t>::max();
    command.echo_sample_time_ns = clock.now_ns();
    Header header;
    header.send_time_ns = bad;
    command.echo_sample = 1;
    meter.on_state_sent(1, clock.now_ns());
    meter.on_force(header, command, clock.now_ns());
    FrameAck drawn{1, bad, 30.0F, 5};
    meter.on_probe_sent(1);
    meter.on_frame_ack(header, drawn, 3);
    meter.on_frame_ack(header, drawn, 1'000'000);
  }
  EXPECT_EQ(stats().wire_out.count(), 0U);
  EXPECT_EQ(stats().motion_to_photon.count(), 0U);
}

TEST_F(HopMeters, MotionToPhotonEndsWithTheFrameNotWithItsAcknowledgement) {
  const std::array<std::byte, 10> bytes = {};
  meter.on_joined(3, {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1}, 5});
  const std::int64_t sample_ns = clock.now_ns();
  metered.send(node->local_address(), bytes);
  meter.on_probe_sent(42);
  clock.advance_ns(9 * kMs);  // 1 ms until it arrives, 8 ms to draw
  Header header;
  header.send_time_ns = clock.now_ns();
  node->send(hub->local_address(), bytes);
  clock.advance_ns(5 * kMs);
  std::array<std::byte, kMaxDatagramBytes> buffer;
  metered.receive(buffer, 0);
  meter.on_frame_ack(header, FrameAck{42, sample_ns, 60.0F, 8 * kMs}, 3);
  EXPECT_EQ(stats().motion_to_photon.max_ns(), 9 * kMs);
  EXPECT_EQ(stats().vision_draw.max_ns(), 8 * kMs);
  meter.on_frame_ack(header, FrameAck{41, sample_ns, 60.0F, 8 * kMs}, 3);  // of a sample that was never sent
  meter.on_frame_ack(header, FrameAck{0, sample_ns, 60.0F, 8 * kMs}, 3);   // names no sample
  meter.on_frame_ack(header, FrameAck{42, sample_ns, 60.0F, 0}, 3);        // does not report how long it drew
  EXPECT_EQ(stats().motion_to_photon.count(), 1U);
}

}  // namespace
}  // namespace hapton
