#include "runtime/file_watch.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using State = FileWatch::State;

struct FileWatchTest : testing::Test {
  void write(const std::string& text) {
    folder.write("a.toml", text);
    // Each write gets its own time: two within one step of the file system's clock would have the same one.
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() + std::chrono::seconds(++writes));
  }

  ScratchFolder folder;
  std::filesystem::path file = folder.path() / "a.toml";
  int writes = 0;
};

TEST_F(FileWatchTest, AChangeIsReportedOnceTwoChecksFindTheSameFile) {
  write("one");
  FileWatch watch(file);
  EXPECT_EQ(watch.check(), State::unchanged);
  write("two");
  EXPECT_EQ(watch.check(), State::waiting);
  write("three");
  EXPECT_EQ(watch.check(), State::waiting) << "the file may still be written";
  EXPECT_EQ(watch.check(), State::changed);
  EXPECT_EQ(watch.check(), State::changed) << "until it is accepted";
  watch.accept();
  EXPECT_EQ(watch.check(), State::unchanged);
}

// As when a file is written twice within one step of the file system's clock.
TEST_F(FileWatchTest, AnotherSizeAtTheSameTimeIsAChange) {
  write("one");
  const auto first_time = std::filesystem::last_write_time(file);
  FileWatch watch(file);
  write("one more");
  std::filesystem::last_write_time(file, first_time);
  EXPECT_EQ(watch.check(), State::waiting);
  EXPECT_EQ(watch.check(), State::changed);
}

TEST_F(FileWatchTest, AFileMissingInTwoChecksIsReportedOnce) {
  write("one");
  FileWatch watch(file);
  const auto aside = folder.path() / "aside";
  std::filesystem::rename(file, aside);
  EXPECT_EQ(watch.check(), State::unchanged) << "missing in one check";
  std::filesystem::rename(aside, file);
  EXPECT_EQ(watch.check(), State::unchanged);
  std::filesystem::rename(file, aside);
  EXPECT_EQ(watch.check(), State::unchanged) << "the first of two in succession";
  EXPECT_FALSE(watch.is_gone());
  EXPECT_EQ(watch.check(), State::gone);
  EXPECT_TRUE(watch.is_gone());
  EXPECT_EQ(watch.check(), State::unchanged) << "reported once";
  EXPECT_TRUE(watch.is_gone());
  std::filesystem::rename(aside, file);
  EXPECT_EQ(watch.check(), State::unchanged) << "the same as before";
  EXPECT_FALSE(watch.is_gone());
}

TEST_F(FileWatchTest, AFileThatAppearsLaterIsAChange) {
  FileWatch watch(file);
  EXPECT_EQ(watch.check(), State::unchanged);
  write("one");
  EXPECT_EQ(watch.check(), State::waiting);
  EXPECT_EQ(watch.check(), State::changed);
}

}  // namespace
}  // namespace hapton
