#include "io_node/vrpn/vrpn_feed.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "devices/simulated_phantom.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/system_call_guard.h"

namespace hapton::vrpn {
namespace {

std::vector<FeedSample> take_all(Feed& feed) {
  std::vector<FeedSample> samples;
  feed.take([&](const FeedSample& sample) { samples.push_back(sample); });
  return samples;
}

std::unique_ptr<Device> simulated_device() { return std::make_unique<SimulatedPhantom>(SimulatedPhantom::Options{}); }

TEST(VrpnFeed, EverySampleArrivesInOrderWithTheWrenchWrittenBeforeIt) {
  Feed feed;
  feed.set_wanted(true);
  WatchedDevice device(simulated_device(), feed);
  const DeviceSample first = device.read(1'000'000);
  device.write({.force_n = Vec3(0, 0, 1)}, 1'000'000);
  device.read(2'000'000);
  const auto samples = take_all(feed);
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].device.p_WD, first.p_WD);
  EXPECT_EQ(samples[0].wrench.force_n, Vec3::Zero());
  EXPECT_EQ(samples[1].device.time_ns, 2'000'000);
  EXPECT_EQ(samples[1].wrench.force_n, Vec3(0, 0, 1));
}

TEST(VrpnFeed, ADeviceThatWasCutHasNoForce) {
  Feed feed;
  feed.set_wanted(true);
  WatchedDevice device(simulated_device(), feed);
  device.write({.force_n = Vec3(0, 0, 1)}, 1'000'000);
  device.cut();
  device.read(2'000'000);
  device.restore();
  device.write({.force_n = Vec3(0, 0, 2)}, 3'000'000);
  device.read(4'000'000);
  const auto samples = take_all(feed);
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].wrench.force_n, Vec3::Zero());
  EXPECT_EQ(samples[1].wrench.force_n, Vec3(0, 0, 2));
}

TEST(VrpnFeed, WithoutClientsNoSampleIsKept) {
  Feed feed;
  WatchedDevice device(simulated_device(), feed);
  device.read(1'000'000);
  EXPECT_TRUE(take_all(feed).empty());
}

TEST(VrpnFeed, ASlowReaderLosesSamples) {
  Feed feed;
  feed.set_wanted(true);
  for (int n = 0; n < 100'000; ++n) feed.push({});
  const std::size_t queued = take_all(feed).size();
  EXPECT_GT(queued, 100U);
  EXPECT_LT(queued, 1000U);
}

TEST(VrpnFeed, TheDeviceIsTheSameAsUnwatched) {
  Feed feed;
  feed.set_wanted(true);
  WatchedDevice watched(simulated_device(), feed);
  const auto unwatched = simulated_device();
  EXPECT_EQ(watched.name(), unwatched->name());
  EXPECT_EQ(watched.limits().max_force_n, unwatched->limits().max_force_n);
  EXPECT_EQ(watched.status(), unwatched->status());
  for (std::int64_t t = 1'000'000; t < 100'000'000; t += 1'000'000) {
    ASSERT_EQ(watched.read(t).p_WD, unwatched->read(t).p_WD);
    watched.write({.force_n = Vec3(0, 1, 0)}, t);
    unwatched->write({.force_n = Vec3(0, 1, 0)}, t);
  }
  EXPECT_EQ(watched.set_hand_target(Vec3::Zero()), unwatched->set_hand_target(Vec3::Zero()));
}

// Records the calls that it gets. Those that end a force, and all others, must reach the device.
class CallRecorder final : public Device {
 public:
  std::string_view name() const noexcept override { return "heard"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t) noexcept override { return {}; }
  void write(const Wrench&, std::int64_t) noexcept override {}
  bool cut() noexcept override { return calls.push_back("cut"), true; }
  void restore() noexcept override { calls.push_back("restore"); }
  void use_heartbeat_page(HeartbeatPage& page) noexcept override { page.set_means(CutMeans::kill); }
  DeviceStatus status() const noexcept override { return DeviceStatus::calibrating; }
  DeviceCondition condition() const noexcept override { return {"Touch", "SN1", "4.5", true, 0.5}; }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return true; }
  bool press_hand_buttons(std::uint32_t buttons) noexcept override { return calls.push_back("press " + std::to_string(buttons)), true; }
  bool turn_hand(const Vec3& turn_rad) noexcept override { return calls.push_back("turn " + std::to_string(turn_rad.x())), true; }
  bool aim_hand(std::span<const Vec3> p_WA) noexcept override { return calls.push_back("aim " + std::to_string(p_WA.size())), true; }

  std::vector<std::string> calls;

 private:
  DeviceLimits limits_;
};

TEST(VrpnFeed, TheDeviceGetsEveryCall) {
  Feed feed;
  auto made = std::make_unique<CallRecorder>();
  const CallRecorder& inner = *made;
  const std::unique_ptr<Device> device = std::make_unique<WatchedDevice>(std::move(made), feed);
  HeartbeatPage page;
  EXPECT_TRUE(device->cut());
  device->restore();
  device->use_heartbeat_page(page);
  EXPECT_EQ(page.means.load(), CutMeans::kill);
  EXPECT_EQ(device->status(), DeviceStatus::calibrating);
  EXPECT_EQ(device->condition().serial, "SN1");
  EXPECT_TRUE(device->press_hand_buttons(3));
  EXPECT_TRUE(device->turn_hand(Vec3(2, 0, 0)));
  EXPECT_TRUE(device->aim_hand(std::array{Vec3(1, 2, 3)}));
  EXPECT_EQ(inner.calls, (std::vector<std::string>{"cut", "restore", "press 3", "turn 2.000000", "aim 1"}));
}

void serve(Device& device) {
  for (std::int64_t t = 1'000'000; t < 1'000'000'000; t += 1'000'000) {
    device.read(t);
    device.write({.force_n = Vec3(0, 0, 0.1)}, t);
  }
}

TEST(VrpnFeed, TheDeviceSideUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  Feed feed;
  feed.set_wanted(true);
  WatchedDevice device(simulated_device(), feed);
  const AllocationGuard guard;
  serve(device);
  EXPECT_EQ(guard.count(), 0U);
}

TEST(VrpnFeed, TheDeviceSideMakesNoSystemCall) {
  if (!SystemCallGuard::is_available()) GTEST_SKIP() << "system calls cannot be forbidden in this build or on this kernel";
  std::unique_ptr<Feed> feed;
  std::unique_ptr<WatchedDevice> device;
  EXPECT_EQ(SystemCallGuard::run(
                [&] {
                  feed = std::make_unique<Feed>();
                  feed->set_wanted(true);
                  device = std::make_unique<WatchedDevice>(simulated_device(), *feed);
                },
                [&] { serve(*device); }),
            "");
}

}  // namespace
}  // namespace hapton::vrpn
