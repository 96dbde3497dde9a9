#include "runtime/writable_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include "runtime/atomic_file.h"
#include "runtime/part_file.h"
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

// No writer makes the folder to which a link points: without this check, writing failed at the end of the run.
TEST(WritablePath, RejectsALinkIntoAFolderThatIsNotThere) {
  const ScratchFolder folder;
  const auto link = folder.path() / "link.csv";
  std::filesystem::create_symlink("later/a.csv", link);
  EXPECT_THAT(error_of(check_writable_file(link)), HasSubstr("link.csv cannot be written: it is a link into"));
  EXPECT_FALSE(write_file_atomically(link, "x"));
  std::filesystem::create_directory(folder.path() / "later");
  EXPECT_EQ(error_of(check_writable_file(link)), "");
  EXPECT_TRUE(write_file_atomically(link, "x"));
}

TEST(WritablePath, RejectsAFolderBehindABrokenLink) {
  const ScratchFolder folder;
  const auto link = folder.path() / "link";
  std::filesystem::create_symlink("nothing", link);
  for (const auto& behind : {link, link / "a", link / "a/b"}) {
    EXPECT_THAT(error_of(check_writable_folder(behind)), HasSubstr("points to something that does not exist")) << behind;
    EXPECT_THAT(error_of(check_writable_file(behind / "a.csv")), HasSubstr("points to something that does not exist")) << behind;
    std::error_code error;
    EXPECT_FALSE(std::filesystem::create_directories(behind, error)) << behind;
  }
  std::filesystem::create_directory(folder.path() / "nothing");
  EXPECT_EQ(error_of(check_writable_folder(link / "a")), "");
}

// A file has a longer name until it is complete.
TEST(WritablePath, RejectsANameThatDoesNotFit) {
  const ScratchFolder folder;
  const auto max_name_bytes = static_cast<std::size_t>(::pathconf(folder.path().c_str(), _PC_NAME_MAX));
  ASSERT_LT(max_name_bytes, 4096U);
  const std::size_t suffix_bytes = PartPath("a").part().string().size() - 1;
  const auto longest = folder.path() / std::string(max_name_bytes - suffix_bytes, 'a');
  EXPECT_EQ(error_of(check_writable_file(longest)), "");
  EXPECT_TRUE(write_file_atomically(longest, "x"));
  const auto longer = folder.path() / std::string(max_name_bytes - suffix_bytes + 1, 'a');
  for (const bool is_there : {false, true}) {
    if (is_there) std::ofstream(longer) << "x";
    EXPECT_THAT(error_of(check_writable_file(longer)),
                HasSubstr(fmt::format("{} bytes, and {} are the most; give a shorter one", max_name_bytes - suffix_bytes + 1,
                                      max_name_bytes - suffix_bytes)))
        << is_there;
    EXPECT_FALSE(write_file_atomically(longer, "x")) << is_there;
  }
  std::filesystem::create_symlink(longer.filename(), folder.path() / "link.csv");
  EXPECT_THAT(error_of(check_writable_file(folder.path() / "link.csv")), HasSubstr("give a shorter one"));
}

TEST(WritablePath, RejectsAFolderWhoseNameDoesNotFit) {
  const ScratchFolder folder;
  const auto max_name_bytes = static_cast<std::size_t>(::pathconf(folder.path().c_str(), _PC_NAME_MAX));
  ASSERT_LT(max_name_bytes, 4096U);
  const std::string longest(max_name_bytes, 'a');
  EXPECT_EQ(error_of(check_writable_folder(folder.path() / longest)), "");
  EXPECT_EQ(error_of(check_writable_folder(folder.path() / longest / "b" / longest)), "");
  for (const auto& longer :
       {folder.path() / (longest + "a"), folder.path() / (longest + "a") / "b", folder.path() / "b" / (longest + "a")}) {
    EXPECT_THAT(error_of(check_writable_folder(longer)), HasSubstr("give a shorter one"));
    EXPECT_THAT(error_of(check_writable_file(longer / "a.csv")), HasSubstr("give a shorter one"));
  }
  std::filesystem::path deep = folder.path();
  while (deep.native().size() < 4096) deep /= std::string(100, 'a');
  EXPECT_THAT(error_of(check_writable_folder(deep)), HasSubstr("give a shorter path"));
  EXPECT_THAT(error_of(check_writable_file(deep / "a.csv")), HasSubstr("give a shorter path"));
}

// The number of bytes that an error names fits, and one more does not.
TEST(WritablePath, NamesHowLongAPathMayBe) {
  const std::size_t suffix_bytes = PartPath("a").part().string().size() - 1;
  const auto path_of = [](std::size_t bytes) {
    std::string path = "/tmp";
    while (path.size() + 101 < bytes) path += "/" + std::string(99, 'a');
    return path + "/" + std::string(bytes - path.size() - 1, 'a');
  };
  EXPECT_EQ(error_of(check_writable_folder(path_of(4095))), "");
  EXPECT_THAT(error_of(check_writable_folder(path_of(4096))), HasSubstr("it has 4096 bytes, and 4095 are the most;"));
  EXPECT_EQ(error_of(check_writable_file(path_of(4095 - suffix_bytes))), "");
  EXPECT_THAT(error_of(check_writable_file(path_of(4096 - suffix_bytes))),
              HasSubstr(fmt::format("it has {} bytes, and {} are the most;", 4096 - suffix_bytes, 4095 - suffix_bytes)));
}

// By its permissions, root may write in /proc.
TEST(WritablePath, RejectsAFolderWhereNothingCanBeMadeDespiteItsPermissions) {
  EXPECT_THAT(error_of(check_writable_folder("/proc/hapton")), HasSubstr("/proc/hapton cannot be written"));
  EXPECT_THAT(error_of(check_writable_file("/proc/hapton.csv")), HasSubstr("cannot be written"));
}

// The file itself is writable, but a new file is written beside it and replaces it: without this check, that failed only after a long run.
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

TEST(WritablePath, TwoNamesOfOneFileAreOneOutput) {
  const ScratchFolder folder;
  const auto file = folder.path() / "a.csv";
  EXPECT_TRUE(is_same_output(file, file)) << "not there yet";
  EXPECT_TRUE(is_same_output(file, folder.path() / "b/.." / "." / "a.csv"));
  EXPECT_FALSE(is_same_output(file, folder.path() / "b.csv"));
  std::filesystem::create_symlink("a.csv", folder.path() / "link.csv");
  EXPECT_TRUE(is_same_output(file, folder.path() / "link.csv")) << "it leads to the file that will be there";
  folder.write("a.csv", "x");
  EXPECT_TRUE(is_same_output(file, folder.path() / "link.csv"));
  std::filesystem::create_directory_symlink(folder.path(), folder.path() / "here");
  EXPECT_TRUE(is_same_output(file, folder.path() / "here/a.csv"));
  EXPECT_TRUE(is_same_output("a.csv", std::filesystem::current_path() / "a.csv"));
  EXPECT_FALSE(is_same_output("/dev/null", "/dev/null")) << "it can take both outputs";
  EXPECT_FALSE(is_same_output("", ""));
  EXPECT_EQ(error_of(check_different_outputs({{"--csv", file}, {"--plot", ""}, {"--out", folder.path() / "b.csv"}})), "");
  EXPECT_EQ(error_of(check_different_outputs({{"--csv", "a.csv"}, {"--plot", ""}, {"--out", "./a.csv"}})),
            "--csv and --out are both ./a.csv; name two files");
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
