#include "runtime/descriptor_check.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

using ::testing::ExitedWithCode;

#if defined(__SANITIZE_ADDRESS__)
constexpr const char* kNothingElse = "\n";  // this sanitizer opens a pipe to look at a pointer, and complains after the line
#else
constexpr const char* kNothingElse = "\n$";
#endif

TEST(DescriptorCheckTest, CountsWhatIsOpen) {
  const DescriptorRoom before = find_descriptor_room();
  EXPECT_GE(before.in_use, 3U);
  EXPECT_EQ(before.left(), before.allowed - before.in_use);
  const int one = open("/dev/null", O_RDONLY);
  const int other = open("/dev/null", O_RDONLY);
  EXPECT_EQ(find_descriptor_room().in_use, before.in_use + 2);
  close(one);
  close(other);
  EXPECT_EQ(find_descriptor_room().in_use, before.in_use);
}

TEST(DescriptorCheckTest, PassesWhereThereIsRoom) { check_descriptors("descriptor_check_test"); }

void check_with(rlim_t allowed) {
  const rlimit limit = {.rlim_cur = allowed, .rlim_max = allowed};
  setrlimit(RLIMIT_NOFILE, &limit);
  check_descriptors("this_test");
  _exit(0);
}

TEST(DescriptorCheckTest, EndsWithOneLineWhereThereIsTooLittle) {
  const std::uint64_t in_use = find_descriptor_room().in_use;
  // From no descriptor left, not even the one that the check itself needs, to one too few.
  for (const std::uint64_t allowed : {std::uint64_t{0}, std::uint64_t{3}, std::uint64_t{8}, in_use + kDescriptorsNeeded - 1}) {
    EXPECT_EXIT(check_with(allowed), ExitedWithCode(1),
                std::string("^this_test: only [0-9]+ file descriptors .*ulimit -n 1024[^\n]*") + kNothingElse)
        << allowed;
  }
  // In the child process, the test program may have a few more descriptors open.
  EXPECT_EXIT(check_with(in_use + kDescriptorsNeeded + 8), ExitedWithCode(0), "^$");
}

}  // namespace
}  // namespace hapton
