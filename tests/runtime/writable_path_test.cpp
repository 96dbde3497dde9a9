#include "runtime/writable_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <iterator>
#include <string>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::string error_of(const Result<void>& checked) { return checked ? "" : checked.error().what; }

TEST(WritablePath, TakesWhatIsThereAndWhatCanBeMade) {
  const ScratchFolder folder;
  const auto file = folder.write("a.csv", "x");
  EXPECT_EQ(error_of(check_writable_folder(folder.path())), "");
  EXPECT_EQ(error_of(check_writable_folder(folder.path() / "b/c/d")), "");
  EXPECT_EQ(error_of(check_writable_file(file)), "");
  EXPECT_EQ(error_of(check_writable_file(folder.path() / "b/c/d.csv")), "");
  EXPECT_EQ(error_of(check_writable_file("d.csv")), "");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "b"));
}

TEST(WritablePath, RejectsAPathThatIsBlocked) {
  const ScratchFolder folder;
  const auto file = folder.write("a.csv", "x");
  EXPECT_THAT(error_of(check_writable_folder(file)), HasSubstr("a.csv is not a folder"));
  EXPECT_THAT(error_of(check_writable_folder(file / "b")), HasSubstr("a.csv is not a folder"));
  EXPECT_THAT(error_of(check_writable_file(file / "b.csv")), HasSubstr("a.csv is not a folder"));
  EXPECT_THAT(error_of(check_writable_file(folder.path())), HasSubstr("it is a folder"));
  EXPECT_THAT(error_of(check_writable_file(folder.path() / "b/")), HasSubstr("it is a folder"));
}

TEST(WritablePath, GoesByWhatALinkLeadsTo) {
  const ScratchFolder folder;
  const auto link = folder.path() / "link.csv";
  std::filesystem::create_symlink("/proc/hapton.csv", link);
  EXPECT_THAT(error_of(check_writable_file(link)), HasSubstr("/proc cannot be written"));
  std::filesystem::remove(link);
  std::filesystem::create_symlink(folder.write("a.csv", "x").filename(), link);
  EXPECT_EQ(error_of(check_writable_file(link)), "");
}

// Its permissions say that root may write there.
TEST(WritablePath, RejectsWhereNothingCanBeMadeThoughItMayBe) {
  EXPECT_THAT(error_of(check_writable_folder("/proc/hapton")), HasSubstr("/proc/hapton cannot be written"));
  EXPECT_THAT(error_of(check_writable_file("/proc/hapton.csv")), HasSubstr("cannot be written"));
}

// It may be written itself, but is written beside and then replaced: that failed only after a long run.
TEST(WritablePath, RejectsAFileWhoseFolderTakesNoOther) {
  ASSERT_EQ(::access("/proc/self/comm", W_OK), 0);
  EXPECT_THAT(error_of(check_writable_file("/proc/self/comm")), HasSubstr("nothing can be made in its folder /proc/self"));
  const ScratchFolder folder;
  std::filesystem::create_symlink("/proc/self/comm", folder.path() / "link.csv");
  EXPECT_THAT(error_of(check_writable_file(folder.path() / "link.csv")), HasSubstr("link.csv cannot be written"));
}

TEST(WritablePath, TakesWhatIsWrittenItself) {
  EXPECT_EQ(error_of(check_writable_file("/dev/null")), "");
  const ScratchFolder folder;
  const auto pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(error_of(check_writable_file(pipe)), "");
}

TEST(WritablePath, LeavesNothingBehind) {
  const ScratchFolder folder;
  ASSERT_EQ(error_of(check_writable_folder(folder.path())), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  const auto file = folder.write("a.csv", "x");
  ASSERT_EQ(error_of(check_writable_file(file)), "");
  using Entries = std::filesystem::directory_iterator;
  EXPECT_EQ(std::distance(Entries(folder.path()), Entries()), 1);
}

}  // namespace
}  // namespace hapton
