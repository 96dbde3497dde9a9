#include "runtime/tick_timer.h"

#include <gtest/gtest.h>

#include "runtime/clock.h"
#include "tests/support/open_files.h"
#include "tests/support/signal_rain.h"

namespace hapton {
namespace {

TEST(TickTimer, WaitsUntilTheTimeThatWasSetLast) {
  SteadyClock clock;
  TickTimer timer;
  ASSERT_TRUE(timer.open());
  const std::int64_t begin_ns = clock.now_ns();
  timer.set(begin_ns + 60 * kNanosecondsPerSecond);
  timer.set(begin_ns + 20 * kNanosecondsPerMillisecond);
  timer.wait();
  EXPECT_GE(clock.now_ns() - begin_ns, 20 * kNanosecondsPerMillisecond);
  EXPECT_LT(clock.now_ns() - begin_ns, 50 * kNanosecondsPerSecond) << "not until the time before";
}

TEST(TickTimer, ASignalDoesNotEndAWait) {
  SteadyClock clock;
  TickTimer timer;
  ASSERT_TRUE(timer.open());
  const std::int64_t until_ns = clock.now_ns() + 50 * kNanosecondsPerMillisecond;
  timer.set(until_ns);
  const SignalRain rain;
  timer.wait();
  EXPECT_GE(clock.now_ns(), until_ns);
}

TEST(TickTimer, ATimeThatHasPassedOrWasNeverSetIsNotWaitedFor) {
  SteadyClock clock;
  TickTimer timer;
  ASSERT_TRUE(timer.open());
  const std::int64_t begin_ns = clock.now_ns();
  timer.wait();
  timer.set(begin_ns - kNanosecondsPerMillisecond);
  timer.wait();
  timer.wait();  // if a wait does not return, the time limit of the test ends it
}

TEST(TickTimer, IsClosedAgain) {
  EXPECT_FALSE(leaves_files_open([] {
    TickTimer timer;
    EXPECT_TRUE(timer.open());
  }));
}

}  // namespace
}  // namespace hapton
