#include "runtime/deadline_thread.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <thread>

#include "runtime/clock.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr int kSchedDeadline = 6;  // SCHED_DEADLINE of the kernel

TEST(DeadlineThread, ChangesTheCallersPolicyOrLeavesItAsItWas) {
  std::thread([] {
    const int before = ::sched_getscheduler(0);
    const bool is_granted = enter_deadline(kMs / 10, kMs);
    EXPECT_EQ(::sched_getscheduler(0) & 0xFF, is_granted ? kSchedDeadline : before);
    // The thread sleeps and wakes like any other.
    SteadyClock clock;
    const std::int64_t due_ns = clock.now_ns() + 5 * kMs;
    clock.sleep_until_ns(due_ns);
    EXPECT_GE(clock.now_ns(), due_ns);
  }).join();
  EXPECT_NE(::sched_getscheduler(0) & 0xFF, kSchedDeadline) << "only the policy of the calling thread changes";
}

TEST(DeadlineThread, ImpossibleValuesAreRejected) {
  std::thread([] { EXPECT_FALSE(enter_deadline(2 * kMs, kMs)); }).join();
}

}  // namespace
}  // namespace hapton
