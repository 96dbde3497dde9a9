#include "runtime/start_thread.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(StartThreadTest, RunsWhatItIsGiven) {
  int reply = 0;
  std::thread thread = start_thread([&] { reply = 42; });
  thread.join();
  EXPECT_EQ(reply, 42);
}

TEST(StartThreadDeathTest, AThreadThatIsDeniedIsOneLineAndEndsTheProgram) {
  const std::system_error rejection(std::make_error_code(std::errc::resource_unavailable_try_again));
  EXPECT_EXIT(end_without_thread(rejection), testing::ExitedWithCode(1), "^[a-z_]+: cannot start another thread .*ulimit -u.*\n$");
}

}  // namespace
}  // namespace hapton
