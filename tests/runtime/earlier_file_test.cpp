#include "runtime/earlier_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <fstream>
#include <iterator>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

struct EarlierFiles : testing::Test {
  ScratchFolder scratch;
  std::filesystem::path recording = scratch.path() / "day.hapton";

  static void write(const std::filesystem::path& path, const std::string& text) { std::ofstream(path) << text; }
  static std::string read(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::size_t count_files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(scratch.path()), {}));
  }
};

TEST_F(EarlierFiles, AreKeptUnderTheFirstFreeNumber) {
  for (const std::string text : {"one", "two", "three"}) {
    write(recording, text);
    const auto kept = keep_earlier_file(recording);
    ASSERT_TRUE(kept) << kept.error().what;
    EXPECT_FALSE(std::filesystem::exists(recording));
    EXPECT_EQ(read(*kept), text);
  }
  EXPECT_EQ(read(scratch.path() / "day-1.hapton"), "one");
  EXPECT_EQ(read(scratch.path() / "day-2.hapton"), "two");
  EXPECT_EQ(read(scratch.path() / "day-3.hapton"), "three");
  std::filesystem::remove(scratch.path() / "day-2.hapton");
  write(recording, "four");
  EXPECT_EQ(*keep_earlier_file(recording), scratch.path() / "day-2.hapton");
  EXPECT_EQ(read(scratch.path() / "day-3.hapton"), "three");
}

TEST_F(EarlierFiles, OfAnyNameAreKept) {
  for (const auto& [name, kept_name] : {std::pair("noextension", "noextension-1"), std::pair(".hidden", ".hidden-1"),
                                        std::pair("a b.c.hapton", "a b.c-1.hapton"), std::pair("t\u00e4g.hapton", "t\u00e4g-1.hapton")}) {
    write(scratch.path() / name, "x");
    const auto kept = keep_earlier_file(scratch.path() / name);
    ASSERT_TRUE(kept) << kept.error().what;
    EXPECT_EQ(kept->filename(), kept_name);
  }
}

TEST_F(EarlierFiles, ThatHoldNothingNeedNotBeKept) {
  EXPECT_EQ(*keep_earlier_file(recording), "") << "there is none";
  write(recording, "");
  EXPECT_EQ(*keep_earlier_file(recording), "") << "it is empty";
  EXPECT_EQ(*keep_earlier_file("/dev/null"), "") << "a device";
  EXPECT_EQ(*keep_earlier_file(scratch.path()), "") << "a folder: opening it fails";
  EXPECT_EQ(count_files(), 1U);
}

TEST_F(EarlierFiles, BehindALinkAreKeptWhereTheyAre) {
  std::filesystem::create_directory(scratch.path() / "disk");
  write(scratch.path() / "disk" / "big.hapton", "data");
  std::filesystem::create_symlink(scratch.path() / "disk" / "big.hapton", recording);
  const auto kept = keep_earlier_file(recording);
  ASSERT_TRUE(kept) << kept.error().what;
  EXPECT_EQ(read(scratch.path() / "disk" / "big-1.hapton"), "data");
  EXPECT_TRUE(std::filesystem::is_symlink(recording)) << "the new file goes to the same disk";
}

TEST_F(EarlierFiles, AProgramGoesOnWritingToWhatIsRenamed) {
  std::ofstream other(recording);
  other << "begun " << std::flush;
  ASSERT_TRUE(keep_earlier_file(recording));
  other << "and ended" << std::flush;
  EXPECT_EQ(read(scratch.path() / "day-1.hapton"), "begun and ended");
}

TEST_F(EarlierFiles, ThatCannotBeRenamedAreNamedInOneLine) {
  if (geteuid() == 0) GTEST_SKIP() << "root may rename everywhere";
  write(recording, "data");
  std::filesystem::permissions(scratch.path(), std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const auto kept = keep_earlier_file(recording);
  std::filesystem::permissions(scratch.path(), std::filesystem::perms::owner_all);
  ASSERT_FALSE(kept);
  EXPECT_THAT(kept.error().what, testing::HasSubstr("day.hapton: exists and cannot be renamed"));
  EXPECT_EQ(kept.error().what.find('\n'), std::string::npos);
  EXPECT_EQ(read(recording), "data");
}

}  // namespace
}  // namespace hapton
