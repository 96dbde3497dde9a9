#include "runtime/bare_timer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

// A clock that oversleeps every tenth time, by oversleep_ns.
class SleepyClock final : public Clock {
 public:
  explicit SleepyClock(std::int64_t oversleep_ns) : oversleep_ns_(oversleep_ns) {}
  std::int64_t now_ns() const noexcept override { return now_ns_; }
  void sleep_until_ns(std::int64_t deadline_ns) noexcept override {
    now_ns_ = std::max(now_ns_, deadline_ns) + (++sleeps_ % 10 == 0 ? oversleep_ns_ : 0);
  }

 private:
  std::int64_t now_ns_ = kNanosecondsPerSecond;
  std::int64_t oversleep_ns_;
  int sleeps_ = 0;
};

TEST(BareTimers, APunctualMachineMissesNothing) {
  SimulatedClock clock;
  const BareTimer timer = run_bare_timer(clock, 1000.0, 2.0);
  EXPECT_EQ(timer.ticks, 2000U);
  EXPECT_EQ(timer.missed, 0U);
  EXPECT_EQ(timer.lateness.max_ns(), 0);
}

TEST(BareTimers, ALateWakeUpWithinItsPeriodIsLateAndMissesNothing) {
  SleepyClock clock(kMs - 1);
  const BareTimer timer = run_bare_timer(clock, 1000.0, 1.0);
  EXPECT_EQ(timer.ticks, 1000U);
  EXPECT_EQ(timer.missed, 0U);
  EXPECT_EQ(timer.lateness.max_ns(), kMs - 1);
}

TEST(BareTimers, WholePeriodsOversleptAreMissed) {
  SleepyClock clock(2 * kMs + kMs / 2);
  const BareTimer timer = run_bare_timer(clock, 1000.0, 1.2);
  EXPECT_EQ(timer.ticks, 1000U);
  EXPECT_EQ(timer.missed, 200U);
  EXPECT_DOUBLE_EQ(timer.missed_share(), 1.0 / 6.0);
}

TEST(BareTimers, TwoOfThemAddUp) {
  SleepyClock clock(kMs);
  BareTimer timer = run_bare_timer(clock, 1000.0, 1.1);
  timer.merge(run_bare_timer(clock, 1000.0, 1.1));
  EXPECT_EQ(timer.ticks, timer.lateness.count());
  EXPECT_EQ(timer.ticks + timer.missed, 2200U);
}

TEST(BareTimers, ARealOneTicksAtTheRequestedRateExceptMissedCycles) {
  const auto timer = measure_bare_timer({.mode = RealtimeMode::off, .lock_memory = false, .low_dma_latency = false}, 500.0, 0.1);
  ASSERT_TRUE(timer);
  EXPECT_GE(timer->ticks + timer->missed, 50U);
}

TEST(BareTimers, NothingMeasuredMissesNothing) { EXPECT_EQ(BareTimer().missed_share(), 0.0); }

}  // namespace
}  // namespace hapton
