#include "io_node/scheduling_monitor.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

ThreadUsage usage_of(double run_s) { return {.run_s = run_s}; }

TEST(SchedulingMonitor, SplitsTheTimeIntoWorkSpinAndSleep) {
  SchedulingMonitor monitor(0.1, 0.95);
  EXPECT_FALSE(monitor.stats().is_known);
  monitor.update({.run_s = 10.0, .waited_s = 1.0, .involuntary_switches = 5, .stolen_s = 2.0}, 7, kSecondNs);
  monitor.update({.run_s = 10.2, .waited_s = 1.01, .involuntary_switches = 8, .stolen_s = 2.5}, 7 + kSecondNs / 20, 2 * kSecondNs);
  const SchedulingStats& stats = monitor.stats();
  ASSERT_TRUE(stats.is_known);
  EXPECT_NEAR(stats.worked_share, 0.15, 1e-9);
  EXPECT_NEAR(stats.spun_share, 0.05, 1e-9);
  EXPECT_NEAR(stats.slept_share, 0.8, 1e-9);
  EXPECT_NEAR(stats.waited_ms, 10.0, 1e-9);
  EXPECT_EQ(stats.involuntary_switches, 3U);
  EXPECT_NEAR(stats.stolen_ms, 500.0, 1e-9);
}

TEST(SchedulingMonitor, SpinningGivesWayToWorkAndToTheKernelsLimit) {
  SchedulingMonitor monitor(0.3, 0.5);
  EXPECT_NEAR(monitor.update(usage_of(0.0), 0, kSecondNs), 0.3, 1e-9);
  EXPECT_NEAR(monitor.update(usage_of(0.05), 0, 2 * kSecondNs), 0.3, 1e-9);
  // kMaxUsedShare of the kernel's limit, less the work.
  EXPECT_NEAR(monitor.update(usage_of(0.35), 0, 3 * kSecondNs), 0.8 * 0.5 - 0.3, 1e-9);
  EXPECT_EQ(monitor.update(usage_of(1.1), 0, 4 * kSecondNs), 0.0);
  EXPECT_NEAR(monitor.update(usage_of(1.1), 0, 5 * kSecondNs), 0.3, 1e-9);
}

TEST(SchedulingMonitor, SpinningDoesNotCountAsWork) {
  SchedulingMonitor monitor(0.3, 0.5);
  monitor.update(usage_of(0.0), 0, kSecondNs);
  EXPECT_NEAR(monitor.update(usage_of(0.3), kSecondNs * 3 / 10, 2 * kSecondNs), 0.3, 1e-9);
}

TEST(SchedulingMonitor, CountsWhenThrottlingIsNear) {
  SchedulingMonitor monitor(0.1, 0.5);
  monitor.update(usage_of(0.0), 0, kSecondNs);
  monitor.update(usage_of(0.4), 0, 2 * kSecondNs);
  EXPECT_EQ(monitor.stats().near_throttling, 0U);
  EXPECT_FALSE(monitor.has_come_near_throttling());
  monitor.update(usage_of(0.89), 0, 3 * kSecondNs);
  EXPECT_EQ(monitor.stats().near_throttling, 1U);
  EXPECT_TRUE(monitor.has_come_near_throttling());
  monitor.update(usage_of(1.38), 0, 4 * kSecondNs);
  EXPECT_EQ(monitor.stats().near_throttling, 2U);
  EXPECT_FALSE(monitor.has_come_near_throttling()) << "not for the first time";
}

}  // namespace
}  // namespace hapton
