#include "runtime/regular_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "tests/support/open_files.h"

namespace hapton {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class RegularFileTest : public testing::Test {
 protected:
  RegularFileTest() { std::filesystem::create_directories(folder_); }
  ~RegularFileTest() override { std::filesystem::remove_all(folder_); }

  std::string rejection(const std::filesystem::path& path, std::size_t max_bytes = 1000) {
    const auto read = read_regular_file(path, "a test's file", max_bytes);
    EXPECT_FALSE(read) << path;
    return read ? "" : read.error().what;
  }

  std::filesystem::path folder_ = std::filesystem::temp_directory_path() / fmt::format("hapton_regular_file_{}", getpid());
};

TEST_F(RegularFileTest, IsReadWhole) {
  const std::string text = std::string(200'000, 'x') + '\0' + "end\n";
  std::ofstream(folder_ / "file", std::ios::binary) << text;
  EXPECT_EQ(read_regular_file(folder_ / "file", ""), text);
  std::ofstream(folder_ / "empty");
  EXPECT_EQ(read_regular_file(folder_ / "empty", ""), "");
  EXPECT_THAT(read_regular_file("/proc/self/status", "").value_or(""), HasSubstr("Name:"));  // of unknown size
}

// Opening a pipe without a writer would block.
TEST_F(RegularFileTest, OtherFilesAreRejectedInOneLine) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  std::filesystem::create_symlink("pipe", folder_ / "link");
  for (const std::filesystem::path& path : {folder_ / "pipe", folder_ / "link", std::filesystem::path("/dev/zero")}) {
    EXPECT_THAT(rejection(path),
                AllOf(StartsWith(path.string() + ": cannot be read: "), HasSubstr("not a regular file"), HasSubstr("; a test's file")));
  }
  EXPECT_THAT(rejection(folder_), HasSubstr("folder"));
  EXPECT_THAT(rejection(folder_ / "gone"), HasSubstr("No such file"));
  std::ofstream(folder_ / "long") << std::string(1001, 'x');
  EXPECT_THAT(rejection(folder_ / "long"), HasSubstr("1001 bytes"));
}

// The size of these files is not known before they are read.
TEST_F(RegularFileTest, WhatIsLongerThanItSaysOrCannotBeReadIsRejected) {
  EXPECT_THAT(rejection("/proc/self/maps", 1), HasSubstr("cannot be read: it grows while it is read; a test's file"));
  EXPECT_THAT(rejection("/proc/self/mem"), HasSubstr("cannot be read: Input/output error; a test's file"));
}

// A hub reads the same files again whenever a scene changes.
TEST_F(RegularFileTest, IsClosedAgain) {
  std::ofstream(folder_ / "file") << "text";
  std::ofstream(folder_ / "long") << std::string(1001, 'x');
  EXPECT_FALSE(leaves_files_open([&] {
    EXPECT_TRUE(read_regular_file(folder_ / "file", ""));
    EXPECT_FALSE(read_regular_file(folder_ / "long", "", 1000));
  }));
}

}  // namespace
}  // namespace hapton
