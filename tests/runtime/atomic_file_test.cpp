#include "runtime/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iterator>

#include "tests/support/open_files.h"

namespace hapton {
namespace {

class AtomicFileTest : public testing::Test {
 protected:
  AtomicFileTest() { std::filesystem::create_directories(folder_); }
  ~AtomicFileTest() override { std::filesystem::remove_all(folder_); }

  std::string read(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  std::filesystem::path folder_ = std::filesystem::temp_directory_path() / fmt::format("hapton_atomic_file_{}", getpid());
};

TEST_F(AtomicFileTest, WritesReplacesAndLeavesNothingBeside) {
  const std::filesystem::path path = folder_ / "new" / "folders" / "file.txt";
  ASSERT_TRUE(write_file_atomically(path, "first"));
  EXPECT_EQ(read(path), "first");
  ASSERT_TRUE(write_file_atomically(path, "second"));
  EXPECT_EQ(read(path), "second");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path.parent_path()), {}), 1);
}

TEST_F(AtomicFileTest, SaysInOneLineWhyItCannotWrite) {
  ASSERT_TRUE(write_file_atomically(folder_ / "file", "x"));
  std::filesystem::create_directories(folder_ / "taken" / "by_a_folder");
  for (const std::filesystem::path& path :
       {folder_ / "file" / "below_a_file", folder_ / "taken", std::filesystem::path("/proc/hapton/x")}) {
    const Result<void> written = write_file_atomically(path, "text");
    ASSERT_FALSE(written) << path;
    EXPECT_THAT(written.error().what, testing::StartsWith("cannot write " + path.string()));
    EXPECT_EQ(written.error().what.find('\n'), std::string::npos);
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 2);
}

TEST_F(AtomicFileTest, AFullDiskLeavesTheOldFile) {
  if (access("/dev/full", W_OK) != 0) {
    GTEST_SKIP() << "no /dev/full here";
  }
  const std::filesystem::path path = folder_ / "file";
  ASSERT_TRUE(write_file_atomically(path, "old"));
  // The temporary file is a device that is always full.
  std::filesystem::create_symlink("/dev/full", folder_ / fmt::format("file.{}.part", getpid()));
  const Result<void> written = write_file_atomically(path, std::string(100'000, 'x'));
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().what, testing::HasSubstr("No space left"));
  EXPECT_EQ(read(path), "old");
}

// This holds whatever the umask of the process is, and whatever permissions the file had before.
TEST_F(AtomicFileTest, WhatIsTheOwnersIsReadableByNobodyElse) {
  const auto permissions_of_others = [&](const std::filesystem::path& path) {
    return std::filesystem::status(path).permissions() & (std::filesystem::perms::group_all | std::filesystem::perms::others_all);
  };
  std::ofstream(folder_ / "old") << "text";
  ASSERT_EQ(::chmod((folder_ / "old").c_str(), 0644), 0);
  const mode_t before = ::umask(0);
  const bool is_written = write_file_atomically(folder_ / "key", "secret", FileReaders::owner).has_value() &&
                          write_file_atomically(folder_ / "report", "text").has_value();
  std::FILE* const old = open_file_for(folder_ / "old", FileReaders::owner);
  ::umask(before);
  ASSERT_TRUE(is_written && old != nullptr);
  std::fclose(old);
  EXPECT_EQ(permissions_of_others(folder_ / "key"), std::filesystem::perms::none);
  EXPECT_EQ(permissions_of_others(folder_ / "old"), std::filesystem::perms::none);
  EXPECT_NE(permissions_of_others(folder_ / "report"), std::filesystem::perms::none);
}

TEST_F(AtomicFileTest, IsClosedAgain) {
  EXPECT_FALSE(leaves_files_open([&] {
    EXPECT_TRUE(write_file_atomically(folder_ / "file", "text"));
    EXPECT_FALSE(write_file_atomically(folder_ / "file" / "below", "text"));
  }));
}

}  // namespace
}  // namespace hapton
