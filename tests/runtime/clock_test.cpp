#include "runtime/clock.h"

#include <gtest/gtest.h>

#include "tests/support/signal_rain.h"

namespace hapton {
namespace {

TEST(SteadyClockTest, SleepsUntilTheDeadlineAndNotLess) {
  SteadyClock clock;
  const std::int64_t deadline_ns = clock.now_ns() + 5 * kNanosecondsPerMillisecond;
  clock.sleep_until_ns(deadline_ns);
  EXPECT_GE(clock.now_ns(), deadline_ns);
}

TEST(SteadyClockTest, ASignalDoesNotEndASleep) {
  SteadyClock clock;
  const SignalRain rain;
  const std::int64_t deadline_ns = clock.now_ns() + 50 * kNanosecondsPerMillisecond;
  clock.sleep_until_ns(deadline_ns);
  EXPECT_GE(clock.now_ns(), deadline_ns);
}

TEST(SteadyClockTest, PastAndNegativeDeadlinesReturn) {
  SteadyClock clock;
  const std::int64_t before_ns = clock.now_ns();
  clock.sleep_until_ns(before_ns - 1);
  clock.sleep_until_ns(0);
  clock.sleep_until_ns(-5);
  EXPECT_GE(clock.now_ns(), before_ns);
}

TEST(SimulatedClockTest, MovesOnlyOnRequest) {
  SimulatedClock clock(100);
  EXPECT_EQ(clock.now_ns(), 100);
  clock.advance_ns(20);
  EXPECT_EQ(clock.now_ns(), 120);
  clock.sleep_until_ns(500);
  EXPECT_EQ(clock.now_ns(), 500);
  clock.sleep_until_ns(400);
  EXPECT_EQ(clock.now_ns(), 500);
}

}  // namespace
}  // namespace hapton
