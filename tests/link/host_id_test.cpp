#include "link/host_id.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hapton {
namespace {

TEST(HostIdTest, IsTheSameInEveryProcessOfAHost) {
  const std::uint64_t here = find_host_id();
  EXPECT_EQ(find_host_id(), here);
  const pid_t child = fork();
  if (child == 0) _exit(find_host_id() == here ? 0 : 1);
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace
}  // namespace hapton
