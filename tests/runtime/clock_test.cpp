#include "runtime/clock.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/time.h>

namespace hapton {
namespace {

TEST(SteadyClockTest, SleepsUntilTheDeadlineAndNotLess) {
  SteadyClock clock;
  const std::int64_t deadline_ns = clock.now_ns() + 5 * kNanosecondsPerMillisecond;
  clock.sleep_until_ns(deadline_ns);
  EXPECT_GE(clock.now_ns(), deadline_ns);
}

TEST(SteadyClockTest, ASignalDoesNotEndASleep) {
  struct sigaction quiet = {};
  struct sigaction before = {};
  quiet.sa_handler = [](int) {};
  ASSERT_EQ(sigaction(SIGALRM, &quiet, &before), 0);
  const itimerval each_ms = {{0, 1000}, {0, 1000}};
  const itimerval never = {};
  SteadyClock clock;
  const std::int64_t deadline_ns = clock.now_ns() + 50 * kNanosecondsPerMillisecond;
  setitimer(ITIMER_REAL, &each_ms, nullptr);
  clock.sleep_until_ns(deadline_ns);
  const std::int64_t woke_ns = clock.now_ns();
  setitimer(ITIMER_REAL, &never, nullptr);
  sigaction(SIGALRM, &before, nullptr);
  EXPECT_GE(woke_ns, deadline_ns);
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
