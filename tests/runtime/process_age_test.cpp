#include "runtime/process_age.h"

#include <chrono>
#include <string>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "runtime/clock.h"
#include "tests/support/scratch_folder.h"

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

// The age of a child process counts from its own start: it is at most the time since the fork plus one step of the kernel's clock.
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

TEST(ProcessAge, IsUnknownWhereTheSystemDoesNotSay) {
  const ScratchFolder folder;
  // 22 words, the last of them the start in ticks; the program's name may hold brackets and blanks.
  std::string stat = "17 (a (b) c) S 1 17 17 0 -1 4194560 90 0 0 0 1 2 0 0 20 0 1 0";
  EXPECT_FALSE(read_process_age_s(folder.path() / "none"));
  EXPECT_FALSE(read_process_age_s(folder.write("empty", "")));
  EXPECT_FALSE(read_process_age_s(folder.write("short", stat)));
  EXPECT_TRUE(read_process_age_s(folder.write("stat", stat + " 5 ")));
}

}  // namespace
}  // namespace hapton
