#include "runtime/process_age.h"

#include <chrono>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "runtime/clock.h"

namespace hapton {
namespace {

TEST(ProcessAge, GrowsAsTimeGoesOn) {
  const auto before = read_process_age_s();
  ASSERT_TRUE(before);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const auto after = read_process_age_s();
  ASSERT_TRUE(after);
  EXPECT_GE(*before, 0.0);
  EXPECT_GE(*after - *before, 0.09);
}

// The age of a process that is started is counted from then on: it is no more than the time since, and a step of the kernel's clock.
TEST(ProcessAge, CountsFromTheStartOfThisProcess) {
  constexpr double kClockStepS = 0.05;
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto parent = read_process_age_s();
  ASSERT_TRUE(parent);
  EXPECT_GE(*parent, 0.25);
  const SteadyClock clock;
  const std::int64_t before_ns = clock.now_ns();
  const pid_t child = fork();
  if (child == 0) {
    const auto own = read_process_age_s();
    _exit(own && *own <= 1e-9 * static_cast<double>(clock.now_ns() - before_ns) + kClockStepS ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace hapton
