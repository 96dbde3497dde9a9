// The network side while the device side computes its forces itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

constexpr double kRestRateHz = 10'000.0;
constexpr std::int64_t kRestPeriodNs = 100 * kUs;

class LocalFloor final : public LocalTouch {
 public:
  std::optional<LocalForce> step(const DeviceSample&) noexcept override {
    return is_there ? std::optional(LocalForce{.force_n = Vec3(0, 0, 1), .contact = true}) : std::nullopt;
  }
  bool is_there = true;
};

// An endpoint in which the network side sleeps. Meanwhile the device side runs its cycles, as its own thread would.
class SleepingEndpoint final : public Endpoint {
 public:
  explicit SleepingEndpoint(SimulatedClock& clock) : clock_(clock) {}
  bool send(const Address&, std::span<const std::byte>) noexcept override { return true; }
  Received receive(std::span<std::byte>, std::int64_t deadline_ns) noexcept override {
    while (loop != nullptr && loop->tick_ns() <= std::max(deadline_ns, clock_.now_ns())) {
      clock_.sleep_until_ns(loop->tick_ns() + std::exchange(late_ns, 0));
      loop->begin_cycle();
      loop->run_cycle();
    }
    clock_.sleep_until_ns(deadline_ns);
    return {};
  }
  Address local_address() const override { return {}; }
  DeviceLoop* loop = nullptr;
  std::int64_t late_ns = 0;  // how late the next cycle begins

 private:
  SimulatedClock& clock_;
};

class CycleTap final : public ServoTap {
 public:
  void on_sent(const Address&, std::span<const std::byte>, std::int64_t) noexcept override {}
  void on_received(const Address&, std::span<const std::byte>, std::int64_t) noexcept override {}
  void on_cycle(const CycleNote& note, std::int64_t) noexcept override { samples.push_back(note.sample); }
  void on_fault(SessionFault fault, std::int64_t) noexcept override { faults.push_back(fault); }
  bool is_recording() const noexcept override { return true; }
  MarkerStatus on_marker(const MarkerNote&, std::int64_t) noexcept override { return MarkerStatus::recorded; }
  std::vector<std::uint64_t> samples;
  std::vector<SessionFault> faults;
};

struct NetworkLoopRest : testing::Test {
  SimulatedClock clock{1'000'000'000};
  SleepingEndpoint endpoint{clock};
  HubPeers peers{endpoint, clock, kSession, kRestRateHz};
  BenchDevice device;
  LocalFloor floor;
  CycleTap tap;
  std::unique_ptr<NetworkLoop> network;

  void make(double vision_rate_hz = 240.0) {
    network = std::make_unique<NetworkLoop>(device, peers, clock,
                                            NetworkLoop::Options{.rate_hz = kRestRateHz, .vision_rate_hz = vision_rate_hz}, nullptr, &tap);
    network->device_loop().set_local_touch(&floor);
    network->use_device_thread();
    network->device_loop().start();
    network->start();
    endpoint.loop = &network->device_loop();
  }
  // How often the network side wakes during this many cycles of the device side.
  int count_steps(int cycles) {
    const std::size_t before = device.reads.size();
    int steps = 0;
    for (; device.reads.size() < before + static_cast<std::size_t>(cycles); ++steps) network->step();
    return steps;
  }
};

TEST_F(NetworkLoopRest, WakesOnceInAMillisecondAndMissesNoCycle) {
  make();
  count_steps(100);
  EXPECT_NEAR(count_steps(10'000), 1000, 10);
  network->step();
  ASSERT_FALSE(tap.samples.empty());
  for (std::size_t n = 0; n < tap.samples.size(); ++n) ASSERT_EQ(tap.samples[n], n + 1);
  EXPECT_GE(tap.samples.size(), 10'090U);
  EXPECT_EQ(network->collect_stats().missed_cycles, 0U);
  EXPECT_TRUE(tap.faults.empty());
}

TEST_F(NetworkLoopRest, WakesAsOftenAsVisionNodesGetStates) {
  make(4000.0);
  count_steps(100);
  // The rest of 0.25 ms ends in the middle of a period of 0.1 ms, so the network side wakes at every third cycle.
  EXPECT_NEAR(count_steps(10'000), 3333, 40);
}

TEST_F(NetworkLoopRest, DoesNotRestWhileForcesComeFromTheNetwork) {
  make();
  floor.is_there = false;
  count_steps(100);
  EXPECT_NEAR(count_steps(1000), 1000, 10);
  floor.is_there = true;
  count_steps(20);
  EXPECT_NEAR(count_steps(1000), 100, 5);
  floor.is_there = false;
  count_steps(20);
  EXPECT_NEAR(count_steps(1000), 1000, 10) << "the network side is back within a rest";
}

TEST_F(NetworkLoopRest, AStallIsAFaultAlsoWhereNewerCyclesFollowedBeforeItWoke) {
  make();
  count_steps(1000);
  EXPECT_TRUE(tap.faults.empty());
  endpoint.late_ns = kCommandTimeoutNs + kRestPeriodNs;
  network->step();
  network->step();
  EXPECT_EQ(tap.faults, std::vector{SessionFault::stalled});
  count_steps(1000);
  EXPECT_EQ(tap.faults.size(), 1U);
}

}  // namespace
}  // namespace hapton
