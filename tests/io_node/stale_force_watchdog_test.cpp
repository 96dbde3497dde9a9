#include "io_node/stale_force_watchdog.h"

#include <gtest/gtest.h>

#include <memory>

#include "devices/simulated_phantom.h"
#include "tests/support/time_units.h"
#include "watchdog/heartbeat_page.h"

namespace hapton {
namespace {

struct StaleForceWatchdogTest : testing::Test {
  StaleForceWatchdogTest() {
    device.use_heartbeat_page(*page);
    loop->set_heartbeat_page(page.get());
  }
  // Runs this many cycles, each with a force in reply.
  void press(int cycles) {
    for (DeviceCycle cycle; cycles > 0; --cycles) {
      clock.sleep_until_ns(loop->tick_ns());
      loop->begin_cycle();
      ASSERT_TRUE(loop->run_cycle());
      while (loop->take_cycle(cycle)) loop->post({{.force_n = Vec3(0, 0, 2)}, cycle.sample.time_ns});
    }
  }
  bool is_cut() const { return page->is_cut_within.load() != 0; }

  SimulatedClock clock;
  SimulatedPhantom device{{}};
  std::unique_ptr<HeartbeatPage> page = std::make_unique<HeartbeatPage>();
  std::unique_ptr<DeviceLoop> loop = std::make_unique<DeviceLoop>(device, clock, DeviceLoop::Options{});
  StaleForceWatchdog watchdog{*loop, clock};
};

TEST_F(StaleForceWatchdogTest, LeavesALivingLoopAlone) {
  for (int n = 0; n < 500; ++n) {
    press(1);
    watchdog.check();
  }
  EXPECT_FALSE(is_cut());
  EXPECT_EQ(loop->collect_stats().cuts, 0U);
}

// The thread of the device loop does not run again: displaced by another, throttled with its whole CPU, or hung in a library.
TEST_F(StaleForceWatchdogTest, ReleasesInTimeWhenTheLoopStalls) {
  press(200);
  const std::int64_t sample_ns = loop->force_sample_ns();
  ASSERT_NE(sample_ns, 0);
  for (std::int64_t due_ns = watchdog.check(); !is_cut() && clock.now_ns() - sample_ns < 1000 * kMs; due_ns = watchdog.check()) {
    clock.sleep_until_ns(due_ns);
  }
  EXPECT_TRUE(is_cut());
  EXPECT_LE(clock.now_ns() - sample_ns, 21 * kMs) << "20 ms and a cycle";
  EXPECT_EQ(loop->collect_stats().cuts, 1U);
}

TEST_F(StaleForceWatchdogTest, WithoutAForceItChecksAgainSoon) {
  EXPECT_LE(watchdog.check() - clock.now_ns(), StaleForceWatchdog::kIdleNs);
  EXPECT_FALSE(is_cut());
}

// A cut just after the loop itself has released the force must not last: the force ramps down, and up again.
TEST_F(StaleForceWatchdogTest, AfterItsCutTheForceRampsUpWhileForcesKeepComing) {
  press(200);
  EXPECT_TRUE(loop->cut_if_older(0));
  ASSERT_TRUE(is_cut());
  press(3);
  EXPECT_FALSE(is_cut());
  EXPECT_LT(loop->latest().written.force_n.norm(), 0.1) << "a ramp, no jump";
  press(200);
  EXPECT_GT(loop->latest().written.force_n.norm(), 1.0);
}

TEST_F(StaleForceWatchdogTest, EndsOnRequest) {
  SteadyClock real_clock;
  const auto running_loop = std::make_unique<DeviceLoop>(device, real_clock, DeviceLoop::Options{});
  StaleForceWatchdog real_watchdog(*running_loop, real_clock);
  real_watchdog.start(true);
  real_watchdog.stop();  // joins its thread: without an end this test would never end
}

}  // namespace
}  // namespace hapton
