// The median of the round trips, from which io_node chooses where the force is computed.
#include <gtest/gtest.h>

#include <cstdint>

#include "io_node/force_exchange.h"
#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

struct RoundTrips : testing::Test {
  SimulatedClock clock;
  ScriptedEndpoint endpoint{clock};
  BenchDevice device;
  HubPeers peers{endpoint, clock, kSession, 1000.0};
  DeviceLoop loop{device, clock, {}};
  ServoStats stats;
  ForceExchange exchange{loop, peers, clock, stats};
  std::uint64_t sample = 0;

  // A sample that gets its reply after round_trip_ns. every_ns: from the reply before to this reply.
  void make_round_trip(std::int64_t round_trip_ns, std::int64_t every_ns = 100 * kMs, bool contact = false) {
    clock.advance_ns(every_ns - round_trip_ns);
    DeviceCycle cycle;
    cycle.number = ++sample;
    cycle.sample.time_ns = clock.now_ns();
    exchange.add_cycle(cycle, true);
    clock.advance_ns(round_trip_ns);
    ForceCommand command;
    command.echo_sample = cycle.number;
    command.echo_sample_time_ns = cycle.sample.time_ns;
    command.compute_ns = 7000;
    command.contact = contact;
    exchange.accept({}, command);
  }
  void make_round_trips(int count, std::int64_t round_trip_ns) {
    for (int n = 0; n < count; ++n) make_round_trip(round_trip_ns);
  }
};

TEST_F(RoundTrips, SixteenAreEnoughForAMedian) {
  for (int n = 1; n <= 15; ++n) {
    make_round_trip(n * kMs);
    EXPECT_EQ(exchange.find_round_trip_s(), -1.0) << n;
    EXPECT_EQ(exchange.find_lasting_round_trip_s(), -1.0) << n;
  }
  make_round_trip(16 * kMs);
  EXPECT_NEAR(exchange.find_round_trip_s(), 0.009, 1e-8) << "of 1 to 16 ms, the ninth";
  EXPECT_NEAR(exchange.find_lasting_round_trip_s(), 0.009, 1e-8);
}

TEST_F(RoundTrips, OneInTwentyMillisecondsCounts) {
  make_round_trip(kMs);
  for (int n = 0; n < 15; ++n) make_round_trip(kMs, 20 * kMs);
  EXPECT_NEAR(exchange.find_round_trip_s(), 0.001, 1e-8);
  exchange.on_haptics_joined();
  make_round_trip(kMs);
  for (int n = 0; n < 29; ++n) make_round_trip(kMs, 10 * kMs + 1);
  EXPECT_EQ(exchange.find_round_trip_s(), -1.0) << "15 of them: the first and each second one of the others";
  make_round_trip(kMs, 10 * kMs);
  EXPECT_NEAR(exchange.find_round_trip_s(), 0.001, 1e-8);
}

TEST_F(RoundTrips, TheNewestMedianIsOf32AndTheLastingOneOf160) {
  make_round_trips(160, 2 * kMs);
  make_round_trips(16, 5 * kMs);
  EXPECT_NEAR(exchange.find_round_trip_s(), 0.005, 1e-8) << "of 16 and 16, the greater";
  EXPECT_NEAR(exchange.find_lasting_round_trip_s(), 0.002, 1e-8);
  make_round_trips(63, 5 * kMs);
  EXPECT_NEAR(exchange.find_lasting_round_trip_s(), 0.002, 1e-8) << "79 of 160";
  make_round_trips(1, 5 * kMs);
  EXPECT_NEAR(exchange.find_lasting_round_trip_s(), 0.005, 1e-8) << "80 of 160";
  make_round_trips(16, 2 * kMs);
  EXPECT_NEAR(exchange.find_round_trip_s(), 0.005, 1e-8);
  make_round_trips(1, 2 * kMs);
  EXPECT_NEAR(exchange.find_round_trip_s(), 0.002, 1e-8);
}

TEST_F(RoundTrips, AfterSettlingTheNewestCountAsLasting) {
  exchange.settle_round_trip();
  EXPECT_EQ(exchange.find_round_trip_s(), -1.0) << "there are none to settle on";
  make_round_trips(160, 2 * kMs);
  make_round_trips(20, 5 * kMs);
  ASSERT_NEAR(exchange.find_lasting_round_trip_s(), 0.002, 1e-8);
  exchange.settle_round_trip();
  EXPECT_NEAR(exchange.find_lasting_round_trip_s(), 0.005, 1e-8);
  EXPECT_NEAR(exchange.find_round_trip_s(), 0.005, 1e-8);
  make_round_trips(80, 3 * kMs);
  EXPECT_NEAR(exchange.find_lasting_round_trip_s(), 0.005, 1e-8) << "80 of 160, and the greater counts";
  make_round_trips(1, 3 * kMs);
  EXPECT_NEAR(exchange.find_lasting_round_trip_s(), 0.003, 1e-8);
  exchange.on_haptics_joined();
  EXPECT_EQ(exchange.find_round_trip_s(), -1.0);
  EXPECT_EQ(exchange.find_lasting_round_trip_s(), -1.0);
}

TEST_F(RoundTrips, EachReplyIsMeasuredOnce) {
  for (int n = 0; n < 10; ++n) make_round_trip(kMs, 100 * kMs, n % 2 == 0);
  EXPECT_EQ(stats.forces, 10U);
  EXPECT_EQ(stats.contact_samples, 5U);
  EXPECT_EQ(stats.round_trip.count(), 10U);
  EXPECT_EQ(stats.round_trip.max_ns(), kMs);
  EXPECT_EQ(stats.haptics_compute.max_ns(), 7000);
  EXPECT_EQ(stats.wire.max_ns(), kMs - 7000);
  EXPECT_EQ(exchange.responses().counts().in_time, 10U);
}

}  // namespace
}  // namespace hapton
