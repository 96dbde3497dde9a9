#include "tools/doctor/run_in_child.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <unistd.h>

namespace hapton::doctor {
namespace {

using ::testing::HasSubstr;

TEST(RunInChild, BringsBackTheAnswer) {
  const ChildAnswer answer = run_in_child([] { return std::string(100'000, 'a'); }, 30.0);
  EXPECT_EQ(answer.failure, "");
  EXPECT_EQ(answer.text, std::string(100'000, 'a'));
}

TEST(RunInChild, IsNotMovedByWhatIsPrinted) {
  const ChildAnswer answer = run_in_child(
      [] {
        std::fputs("a banner of the vendor's\n", stdout);
        std::fflush(stdout);
        return std::string("an answer");
      },
      30.0);
  EXPECT_EQ(answer.text, "an answer");
}

TEST(RunInChild, OutlivesACrash) {
  const ChildAnswer answer = run_in_child(
      [] {
        std::raise(SIGKILL);
        return std::string();
      },
      30.0);
  EXPECT_THAT(answer.failure, HasSubstr("signal 9"));
  EXPECT_THAT(run_in_child([]() -> std::string { ::_exit(3); }, 30.0).failure, HasSubstr("exit code 3"));
}

TEST(RunInChild, DoesNotWaitForEver) {
  const ChildAnswer answer = run_in_child(
      []() -> std::string {
        while (true) ::pause();
      },
      0.05);
  EXPECT_THAT(answer.failure, HasSubstr("did not come back"));
}

}  // namespace
}  // namespace hapton::doctor
