#include "watchdog/watchdog_process.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <functional>

#include "runtime/clock.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// The program that was built beside the nodes.
std::filesystem::path program() { return std::filesystem::path(HAPTON_BIN_DIR) / "hapton_watchdog"; }

struct WatchdogProcessTest : testing::Test {
  void SetUp() override { ASSERT_TRUE(memory.make()); }
  bool wait_until(const std::function<bool()>& holds) {
    const std::int64_t end_ns = clock.now_ns() + 30'000 * kMs;
    for (; clock.now_ns() < end_ns; clock.sleep_until_ns(clock.now_ns() + 5 * kMs)) {
      if (holds()) return true;
    }
    return false;
  }
  SteadyClock clock;
  HeartbeatMemory memory;
  WatchdogProcess watchdog;
};

TEST_F(WatchdogProcessTest, LooksAndIsStartedAgainWhenItDied) {
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  ASSERT_TRUE(wait_until([&] { return memory.page().guard_beat_ns.load() > 0; }));
  EXPECT_FALSE(watchdog.look_after(clock.now_ns()));
  const pid_t first = watchdog.id();
  ::kill(first, SIGKILL);
  ASSERT_TRUE(wait_until([&] { return watchdog.look_after(clock.now_ns()); }));
  EXPECT_NE(watchdog.id(), first);
  EXPECT_EQ(watchdog.restarts(), 1U);
  ::kill(watchdog.id(), SIGKILL);
}

TEST_F(WatchdogProcessTest, AStalledOneIsReplaced) {
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  ASSERT_TRUE(wait_until([&] { return memory.page().guard_beat_ns.load() > 0; }));
  ::kill(watchdog.id(), SIGSTOP);
  ASSERT_TRUE(wait_until([&] { return watchdog.look_after(clock.now_ns()); }));
  const std::int64_t replaced_ns = clock.now_ns();
  EXPECT_TRUE(wait_until([&] { return memory.page().guard_beat_ns.load() > replaced_ns; }));
  ::kill(watchdog.id(), SIGKILL);
}

TEST_F(WatchdogProcessTest, WhatEndsAUnitDoesNotEndIt) {
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  ASSERT_TRUE(wait_until([&] { return memory.page().guard_beat_ns.load() > 0; }));
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) ::kill(watchdog.id(), signal);
  const std::int64_t requested_ns = clock.now_ns();
  EXPECT_TRUE(wait_until([&] { return memory.page().guard_beat_ns.load() > requested_ns + 20 * kMs; }));
  ::kill(watchdog.id(), SIGKILL);
}

TEST_F(WatchdogProcessTest, CutsWhatTheDeviceSideLeavesOut) {
  memory.page().set_means(CutMeans::simulated);
  ASSERT_TRUE(watchdog.start(memory, program(), 0));
  memory.page().heartbeat_ns = clock.now_ns();
  memory.page().force_sample_ns = clock.now_ns();
  ASSERT_TRUE(wait_until([&] { return memory.page().is_cut.load() != 0; }));
  EXPECT_EQ(watchdog.cuts(), 1U);
  EXPECT_GT(memory.page().longest_force_ns.load(), 20 * kMs);
  ::kill(watchdog.id(), SIGKILL);
}

TEST_F(WatchdogProcessTest, AProgramThatIsNotThereIsOneClearLine) {
  const auto started = watchdog.start(memory, "/nowhere/hapton_watchdog", 0);
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().what.find("/nowhere/hapton_watchdog"), std::string::npos);
  EXPECT_NE(started.error().what.find("--watchdog off"), std::string::npos);
  EXPECT_FALSE(watchdog.is_started());
}

}  // namespace
}  // namespace hapton
