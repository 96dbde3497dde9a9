#include "runtime/process_age.h"

#include <chrono>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

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

// A process that has just been started is younger than the one that has slept before.
TEST(ProcessAge, CountsFromTheStartOfThisProcess) {
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto parent = read_process_age_s();
  ASSERT_TRUE(parent);
  const pid_t child = fork();
  if (child == 0) {
    const auto own = read_process_age_s();
    _exit(own && *own < *parent ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace hapton
