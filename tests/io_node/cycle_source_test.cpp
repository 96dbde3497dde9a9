#include "io_node/cycle_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/io_node/network_loop_fixture.h"
#include "tests/support/ticking_clock.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, ACycleThatComesTooLateSkipsWholePeriodsAndCountsThem) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(100);
  const std::int64_t last_read_ns = device.reads.back();
  clock.advance_ns(7 * kMs + 300 * kUs);
  run(5);
  // A cycle ends when its force is written, 100 us after its tick, so the loop is 6.4 ms late for the next tick.
  EXPECT_EQ(stats().missed_cycles, 6U);
  EXPECT_EQ(stats().wake_lateness.max_ns(), 6400 * kUs);
  const std::size_t n = device.reads.size();
  EXPECT_EQ(device.reads[n - 1] - last_read_ns, 11 * kMs);
  EXPECT_EQ(device.reads[n - 1] - device.reads[n - 2], kMs);
  EXPECT_NEAR(stats().seconds(), 0.111, 1e-12);
}

TEST_F(NetworkLoops, EveryMissedCycleHasItsCause) {
  make();
  device.clock = &clock;
  join(kHaptics, NodeRole::haptics);
  run(100);
  device.slow_read_ns = 3 * kMs;
  run(5);
  EXPECT_EQ(missed_by(stats(), MissCause::device_slow), 2U);
  clock.advance_ns(3 * kMs);  // the time passes between a cycle's force and the wait for the next tick
  run(5);
  EXPECT_EQ(missed_by(stats(), MissCause::work_long), 2U);
  clock.advance_ns(30 * kMs);
  run(5);
  EXPECT_EQ(missed_by(stats(), MissCause::machine_stalled), 29U);
  EXPECT_EQ(stats().missed_cycles, 33U);
}

TEST_F(NetworkLoops, AFloodIsHandledOnlyUpToTheBudgetOfACycle) {
  class Flood final : public Endpoint {
   public:
    explicit Flood(SimulatedClock& c) : clock(c) {}
    bool send(const Address&, std::span<const std::byte>) noexcept override { return true; }
    Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
      if (++received_count > 100'000) clock.sleep_until_ns(deadline_ns);  // so that the test ends even if no budget limits the loop
      into.front() = std::byte{0};
      return {.bytes = 1, .from = {}};
    }
    Address local_address() const override { return {}; }
    SimulatedClock& clock;
    std::int64_t received_count = 0;
  };
  for (const int rate_hz : {1000, 4000}) {
    Flood flood(clock);
    BudgetedEndpoint budget(flood, clock);
    HubPeers no_nodes(budget, clock, kSession, rate_hz);
    NetworkLoop own_network(device, no_nodes, clock, {.rate_hz = static_cast<double>(rate_hz)});
    own_network.set_budget(&budget);
    constexpr int kCycles = 20;
    for (int n = 0; n < kCycles; ++n) own_network.step();
    EXPECT_EQ(flood.received_count, kCycles * CycleSource::kDatagramsPerMs * 1000 / rate_hz) << rate_hz;
    EXPECT_GT(budget.spent(), 0U);
  }
}

TEST_F(NetworkLoops, AWaitThatEndsLateIsALateWakeUp) {
  class Oversleeping final : public Endpoint {
   public:
    explicit Oversleeping(SimulatedClock& c) : clock(c) {}
    bool send(const Address&, std::span<const std::byte>) noexcept override { return true; }
    Received receive(std::span<std::byte>, std::int64_t deadline_ns) noexcept override {
      clock.sleep_until_ns(deadline_ns + std::exchange(oversleep_ns, 0));
      return {};
    }
    Address local_address() const override { return {}; }
    SimulatedClock& clock;
    std::int64_t oversleep_ns = 0;
  };
  Oversleeping sleepy(clock);
  HubPeers no_nodes(sleepy, clock, kSession, 1000.0);
  NetworkLoop own_network(device, no_nodes, clock, {});
  for (int n = 0; n < 10; ++n) own_network.step();
  sleepy.oversleep_ns = 2 * kMs + 1;
  for (int n = 0; n < 10; ++n) own_network.step();
  EXPECT_EQ(missed_by(own_network.collect_stats(), MissCause::late_wake_up), 2U);
  EXPECT_EQ(own_network.collect_stats().missed_cycles, 2U);
}

TEST_F(NetworkLoops, AWaitForTheEchoThatEndsLateIsALateWakeUp) {
  ScriptedEndpoint echo_endpoint(clock);
  std::int64_t late_ns = 0;
  echo_endpoint.on_send_raw = [&](const Address& to, std::span<const std::byte> bytes) {
    if (late_ns > 0) clock.advance_ns(std::exchange(late_ns, 0));
    echo_endpoint.arrive_raw(clock.now_ns() + 30 * kUs, to, bytes);
  };
  EchoProbe echo(echo_endpoint, clock, {{5}, 5});
  make({}, &echo);
  join(kHaptics, NodeRole::haptics);
  run(100);
  late_ns = 3 * kMs;
  run(5);
  EXPECT_EQ(missed_by(stats(), MissCause::late_wake_up), stats().missed_cycles);
  EXPECT_GT(stats().missed_cycles, 1U);
}

TEST_F(NetworkLoops, ALoopThatWakesLateLearnsToWakeEarlyAndBeginsOnTime) {
  class Late final : public Endpoint {
   public:
    explicit Late(SimulatedClock& c) : clock(c) {}
    bool send(const Address&, std::span<const std::byte>) noexcept override { return true; }
    Received receive(std::span<std::byte>, std::int64_t deadline_ns) noexcept override {
      if (deadline_ns > clock.now_ns()) clock.sleep_until_ns(deadline_ns + 20 * kUs);
      return {};
    }
    Address local_address() const override { return {}; }
    SimulatedClock& clock;
  };
  Late late(clock);
  TickingClock ticking(clock);
  HubPeers no_nodes(late, ticking, kSession, 1000.0);
  NetworkLoop own_network(device, no_nodes, ticking, {.spin_share = 0.1});
  for (int n = 0; n < 3000; ++n) own_network.step();
  const ServoStats& measured = own_network.collect_stats();
  EXPECT_LT(measured.wake_lateness.quantile_ns(0.5), 1000.0);
  EXPECT_GT(measured.wake_lateness.max_ns(), 19 * kUs);  // before the loop had learnt to wake early
  EXPECT_GT(own_network.spin().spun_ns(), 0);
  EXPECT_LT(own_network.spin().spun_ns(), 3000 * 20 * kUs);
  EXPECT_EQ(measured.missed_cycles, 0U);
}

TEST_F(NetworkLoops, CatchingUpRunsEveryMissedCycleAtOnce) {
  make({.overrun = OverrunPolicy::catch_up});
  join(kHaptics, NodeRole::haptics);
  run(100);
  const std::size_t reads_before = device.reads.size();
  const std::int64_t next_tick_ns = device.reads.back() + kMs;
  clock.advance_ns(5 * kMs);
  run(20);
  EXPECT_EQ(stats().missed_cycles, 0U);
  EXPECT_EQ(missed_by(stats(), MissCause::work_long), stats().caught_up_cycles);
  EXPECT_GE(stats().caught_up_cycles, 4U);
  // The loop is on time again, and no cycle was left out.
  EXPECT_EQ(device.reads.back(), next_tick_ns + static_cast<std::int64_t>(device.reads.size() - 1 - reads_before) * kMs);
}

TEST_F(NetworkLoops, CatchingUpHasAnEnd) {
  make({.overrun = OverrunPolicy::catch_up});
  run(10);
  clock.advance_ns(1000 * kMs);
  run(1000);
  EXPECT_GT(stats().missed_cycles, 980U);
  EXPECT_LE(stats().caught_up_cycles, 11U);
}

TEST_F(NetworkLoops, AMissedCycleStopsTheSessionIfRequested) {
  make({.overrun = OverrunPolicy::stop});
  run(100);
  EXPECT_FALSE(network->has_overrun());
  clock.advance_ns(3 * kMs);
  run(1);
  EXPECT_TRUE(network->has_overrun());
}

TEST_F(NetworkLoops, AFloodOfRubbishDoesNotHoldUpTheLoop) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(200);
  // More datagrams than a late loop handles in a cycle. All of them are there already, and the clock does not advance meanwhile.
  const std::byte rubbish[] = {std::byte{1}, std::byte{2}, std::byte{3}};
  clock.advance_ns(5 * kMs);
  for (int n = 0; n < 500; ++n) endpoint.arrive_raw(clock.now_ns(), at(66), rubbish);
  const std::size_t reads_before = device.reads.size();
  const std::uint64_t undecodable_before = stats().hub.undecodable;
  network->step();
  EXPECT_EQ(device.reads.size(), reads_before + 1);
  run(100);
  EXPECT_EQ(stats().hub.undecodable, undecodable_before + 500);
  EXPECT_EQ(stats().governor.counters.command_timeouts, 0U);
}

}  // namespace
}  // namespace hapton
