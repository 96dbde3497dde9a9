#include "io_node/device_thread.h"

#include <gtest/gtest.h>

#include <memory>

#include "devices/simulated_phantom.h"
#include "runtime/thread_usage.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

struct DeviceThreadTest : testing::Test {
  SteadyClock clock;
  SimulatedPhantom device{{}};
  std::unique_ptr<DeviceLoop> loop = std::make_unique<DeviceLoop>(device, clock, DeviceLoop::Options{});
};

TEST_F(DeviceThreadTest, CyclesUntilItIsStopped) {
  DeviceThread thread(*loop, clock);
  ASSERT_TRUE(thread.start({.mode = RealtimeMode::off}));
  EXPECT_NE(thread.id(), current_thread_id());
  const std::int64_t end_ns = clock.now_ns() + 30'000 * kMs;
  std::uint64_t cycles = 0;
  for (DeviceCycle cycle; cycles < 50 && clock.now_ns() < end_ns;) {
    while (loop->take_cycle(cycle)) ++cycles;
    clock.sleep_until_ns(clock.now_ns() + kMs);
  }
  EXPECT_GE(cycles, 50U);
  EXPECT_GT(loop->heartbeat_ns(), 0);
  thread.stop();
  const std::uint64_t samples = loop->collect_stats().samples;
  clock.sleep_until_ns(clock.now_ns() + 20 * kMs);
  EXPECT_EQ(loop->collect_stats().samples, samples);
}

TEST_F(DeviceThreadTest, RealTimeThatIsRequiredAndDeniedIsAnError) {
  DeviceThread thread(*loop, clock);
  const auto started = thread.start({.mode = RealtimeMode::require, .priority = 80, .cpu = 4095});
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().what.find("CPU"), std::string::npos);
}

TEST_F(DeviceThreadTest, AThreadThatNeverBeganEnds) {
  const DeviceThread thread(*loop, clock);
  EXPECT_EQ(thread.id(), 0);
}

}  // namespace
}  // namespace hapton
