// A cycle of the network loop allocates nothing from the heap.
#include <gtest/gtest.h>

#include <memory>

#include "devices/replay_device.h"
#include "devices/simulated_phantom.h"
#include "io_node/network_loop.h"
#include "io_node/session_recorder.h"
#include "tests/io_node/fixed_endpoint.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

std::uint64_t allocations_of_a_session(Device& device, ServoTap* tap = nullptr) {
  SimulatedClock clock;
  FixedEndpoint endpoint(clock);
  MeteredEndpoint metered(endpoint, clock);
  HopMeter hop_meter(metered);
  ReportServer report_server;
  report_server.publish(std::string(5000, 'j'), "csv");
  HubPeers peers(metered, clock, 5, 1000.0);
  const auto network = std::make_unique<NetworkLoop>(device, peers, clock, NetworkLoop::Options{}, nullptr, tap);
  network->set_hop_meter(&hop_meter);
  network->set_report_server(&report_server);
  Settings settings{2000.0, {'p', 'r', 'o', 'x', 'y'}, true};
  AllocationGuard guard;
  for (int n = 0; n < 3000; ++n) {
    const std::int64_t now = clock.now_ns();
    switch (n % 50) {
      case 0:
        endpoint.say(1, Hello{NodeRole::haptics}, now);
        break;
      case 10:
        endpoint.say(2, Hello{NodeRole::vision}, now);
        break;
      case 20:
        endpoint.say(2, ViewTransform{}, now);
        break;
      case 30:
        endpoint.say(2, HandTarget{n % 100 == 30, Vec3(0, 0, 0.01)}, now);
        break;
      case 40:
        endpoint.say(3, Hello{NodeRole::tool}, now);
        break;
      case 45:
        endpoint.say(3, settings, now);
        break;
      case 47:
        endpoint.say(3, ReportRequest{ReportDocument::json, 1, 2}, now);
        break;
      default:
        break;
    }
    if (n % 500 == 0) network->request_snapshot();
    network->step();
  }
  network->finish();
  const std::uint64_t allocations = guard.count();
  EXPECT_GT(network->collect_stats().forces, 2000U);
  EXPECT_EQ(network->rate_hz(), 2000.0);
  EXPECT_GT(network->collect_stats().hops.encode.count(), 2000U);
  EXPECT_TRUE(network->take_snapshot());
  peers.set_tap(nullptr);
  return allocations;
}

TEST(NetworkLoopHeap, ASessionWithTheSimulatedDeviceAllocatesNothing) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  SimulatedPhantom device({});
  EXPECT_EQ(allocations_of_a_session(device), 0U);
}

TEST(NetworkLoopHeap, ASessionWithAReplayAllocatesNothing) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  ReplayDevice device({{0.0, Vec3::Zero(), Quat::Identity()}, {0.1, Vec3::UnitX(), Quat::Identity()}}, {.loop = true});
  EXPECT_EQ(allocations_of_a_session(device), 0U);
}

TEST(NetworkLoopHeap, ARecordedSessionAllocatesNothingInTheNetworkThread) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  ScratchFolder scratch;
  const SteadyClock clock;
  SessionRecorder recorder({scratch.path() / "session.hapton", scratch.path() / "flight"}, {}, clock);
  ASSERT_TRUE(recorder.start());
  SimulatedPhantom device({});
  EXPECT_EQ(allocations_of_a_session(device, &recorder), 0U);
  ASSERT_TRUE(recorder.stop());
  EXPECT_GT(recorder.counts().entries, 9000U);
}

TEST(NetworkLoopHeap, TheGuardSeesAnAllocation) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  AllocationGuard guard;
  ::operator delete(::operator new(100));
  EXPECT_EQ(guard.count(), 1U);
}

}  // namespace
}  // namespace hapton
