#include "watchdog/heartbeat_memory.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <fstream>
#include <string>

#include "tests/support/open_files.h"

namespace hapton {
namespace {

std::size_t count_mapped_pages() {
  std::ifstream maps("/proc/self/maps");
  std::size_t count = 0;
  for (std::string line; std::getline(maps, line);) count += line.find("memfd:hapton-heartbeat") != std::string::npos ? 1 : 0;
  return count;
}

TEST(HeartbeatMemoryTest, OneSideSeesWhatTheOtherWrites) {
  HeartbeatMemory ours;
  ASSERT_TRUE(ours.make());
  HeartbeatMemory theirs;
  ASSERT_TRUE(theirs.open(::dup(ours.file())));
  ours.page().heartbeat_ns = 77;
  EXPECT_EQ(theirs.page().heartbeat_ns.load(), 77);
  theirs.page().is_cut = 1;
  EXPECT_EQ(ours.page().is_cut.load(), 1U);
}

TEST(HeartbeatMemoryTest, MayBeTheFirstFileOfAProcess) {
  const auto make_it = [] {
    ::close(0);
    HeartbeatMemory memory;
    _exit(memory.make() ? 0 : 1);
  };
  EXPECT_EXIT(make_it(), testing::ExitedWithCode(0), "");
}

TEST(HeartbeatMemoryTest, OtherMemoryIsRejected) {
  const int small = ::memfd_create("small", MFD_CLOEXEC);
  HeartbeatMemory memory;
  EXPECT_FALSE(memory.open(small));
  EXPECT_FALSE(memory.is_there());
  const int other = ::memfd_create("other", MFD_CLOEXEC);
  ASSERT_EQ(::ftruncate(other, 1 << 16), 0);
  HeartbeatMemory zeros;
  const auto opened = zeros.open(other);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().what.find("version"), std::string::npos);
}

TEST(HeartbeatMemoryTest, IsClosedAgain) {
  EXPECT_FALSE(leaves_files_open([] {
    HeartbeatMemory ours;
    ASSERT_TRUE(ours.make());
    HeartbeatMemory theirs;
    ASSERT_TRUE(theirs.open(::dup(ours.file())));
    EXPECT_EQ(count_mapped_pages(), 2U);
  }));
  EXPECT_EQ(count_mapped_pages(), 0U);
}

}  // namespace
}  // namespace hapton
