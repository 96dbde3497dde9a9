#include "hid/device_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <optional>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

struct DeviceLocks : testing::Test {
  DeviceLocks() { std::ofstream(path) << "a node"; }
  ScratchFolder folder;
  std::string path = folder.path() / "node";
};

TEST_F(DeviceLocks, ASecondOneOfTheSameProcessIsRejectedWithOneLine) {
  const auto first = DeviceLock::take(path);
  ASSERT_TRUE(first);
  const auto second = DeviceLock::take(path);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().what.rfind(path, 0), 0U) << second.error().what;
  EXPECT_EQ(second.error().what.find('\n'), std::string::npos);
}

TEST_F(DeviceLocks, ItEndsWithItsHolder) {
  std::optional<Result<DeviceLock>> first(DeviceLock::take(path));
  ASSERT_TRUE(*first);
  const DeviceLock moved = std::move(**first);
  first.reset();
  EXPECT_FALSE(DeviceLock::take(path)) << "moved, not released";
  {
    const auto nothing = DeviceLock::take(path + "2");
    EXPECT_TRUE(nothing) << "opening it for use will say that it is not there";
  }
}

TEST_F(DeviceLocks, AnotherProcessIsRejectedUntilThisOneReleasesIt) {
  const auto is_free_elsewhere = [&] {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(DeviceLock::take(path) ? 0 : 1);
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  };
  {
    const auto lock = DeviceLock::take(path);
    ASSERT_TRUE(lock);
    EXPECT_FALSE(is_free_elsewhere());
  }
  EXPECT_TRUE(is_free_elsewhere());
}

}  // namespace
}  // namespace hapton
