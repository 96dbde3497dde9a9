#include "runtime/writable_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

// Its permissions say that root may write there.
TEST(WritablePath, RejectsWhereNothingCanBeMadeThoughItMayBe) {
  EXPECT_THAT(error_of(check_writable_folder("/proc/hapton")), HasSubstr("/proc/hapton cannot be written"));
  EXPECT_THAT(error_of(check_writable_file("/proc/hapton.csv")), HasSubstr("cannot be written"));
}

TEST(WritablePath, LeavesNothingBehind) {
  const ScratchFolder folder;
  ASSERT_EQ(error_of(check_writable_folder(folder.path())), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace hapton
