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

TEST(RunInChild, BringsBackTheReply) {
  const ChildReply reply = run_in_child([] { return std::string(100'000, 'a'); }, 30.0);
  EXPECT_EQ(reply.failure, "");
  EXPECT_EQ(reply.text, std::string(100'000, 'a'));
}

TEST(RunInChild, TheReplyIsNotChangedByWhatTheChildPrints) {
  const ChildReply reply = run_in_child(
      [] {
        std::fputs("a banner of the vendor's\n", stdout);
        std::fflush(stdout);
        return std::string("a reply");
      },
      30.0);
  EXPECT_EQ(reply.text, "a reply");
}

TEST(RunInChild, OutlivesACrash) {
  const ChildReply reply = run_in_child(
      [] {
        std::raise(SIGKILL);
        return std::string();
      },
      30.0);
  EXPECT_THAT(reply.failure, HasSubstr("signal 9"));
  EXPECT_THAT(run_in_child([]() -> std::string { ::_exit(3); }, 30.0).failure, HasSubstr("exit code 3"));
}

TEST(RunInChild, DoesNotWaitForEver) {
  const ChildReply reply = run_in_child(
      []() -> std::string {
        while (true) ::pause();
      },
      0.05);
  EXPECT_THAT(reply.failure, HasSubstr("did not come back"));
}

}  // namespace
}  // namespace hapton::doctor
