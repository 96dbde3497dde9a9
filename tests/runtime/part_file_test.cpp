#include "runtime/part_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/file_size_limit.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::ptrdiff_t count_files(const ScratchFolder& scratch) {
  return std::distance(std::filesystem::directory_iterator(scratch.path()), std::filesystem::directory_iterator());
}

TEST(PartFile, AppearsWhenItIsKept) {
  const ScratchFolder scratch;
  const auto path = scratch.write("a.csv", "old");
  auto file = PartFile::open(path);
  ASSERT_TRUE(file) << file.error().what;
  file->check(std::fputs("new", file->get()) >= 0);
  ASSERT_TRUE(file->close());
  EXPECT_EQ(text_of(path), "old");
  ASSERT_TRUE(file->keep());
  EXPECT_EQ(text_of(path), "new");
  EXPECT_EQ(count_files(scratch), 1);
}

TEST(PartFile, ALinkStaysAndLeadsToWhatWasWritten) {
  const ScratchFolder scratch;
  const auto target = scratch.write("a.csv", "old");
  const auto link = scratch.path() / "link.csv";
  std::filesystem::create_symlink(target.filename(), link);
  auto file = PartFile::open(link);
  ASSERT_TRUE(file) << file.error().what;
  file->check(std::fputs("new", file->get()) >= 0);
  ASSERT_TRUE(file->close());
  ASSERT_TRUE(file->keep());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(text_of(target), "new");
  EXPECT_EQ(count_files(scratch), 2);
}

TEST(PartFile, ALinkToWhatDoesNotExistYetStays) {
  const ScratchFolder scratch;
  const auto target = scratch.path() / "a.csv";
  const auto second = scratch.path() / "second.csv";
  const auto link = scratch.path() / "link.csv";
  std::filesystem::create_symlink(target.filename(), second);
  std::filesystem::create_symlink(second, link);
  auto file = PartFile::open(link);
  ASSERT_TRUE(file) << file.error().what;
  file->check(std::fputs("new", file->get()) >= 0);
  ASSERT_TRUE(file->close());
  ASSERT_TRUE(file->keep());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_TRUE(std::filesystem::is_symlink(second));
  EXPECT_EQ(text_of(target), "new");
}

TEST(PartFile, ALinkToAPipeIsThePipe) {
  const ScratchFolder scratch;
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const auto link = scratch.path() / "out.csv";
  std::filesystem::create_symlink(fmt::format("/proc/self/fd/{}", ends[1]), link);
  auto file = PartFile::open(link);
  ASSERT_TRUE(file) << file.error().what;
  file->check(std::fputs("new", file->get()) >= 0);
  ASSERT_TRUE(file->close());
  ASSERT_TRUE(file->keep());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  char text[4] = {};
  EXPECT_EQ(read(ends[0], text, 3), 3);
  EXPECT_STREQ(text, "new");
  close(ends[0]);
  close(ends[1]);
}

TEST(PartFile, LeavesNothingIfItIsNotKept) {
  const ScratchFolder scratch;
  const auto path = scratch.write("a.csv", "old");
  for (const bool is_closed : {false, true}) {
    auto file = PartFile::open(path);
    ASSERT_TRUE(file);
    const PartFile moved = std::move(*file);
    std::fputs("new", moved.get());
    EXPECT_EQ(count_files(scratch), 2);
    if (is_closed) {
      PartFile closed_only = PartFile(PartFile::open(scratch.path() / "b.csv").value());
      EXPECT_TRUE(closed_only.close());
    }
  }
  EXPECT_EQ(text_of(path), "old");
  EXPECT_EQ(count_files(scratch), 1);
}

// A full disk shows when a buffer is written, or only at the end.
TEST(PartFile, AFailedWriteIsReportedInOneLineAndLeavesTheEarlierFile) {
  const ScratchFolder scratch;
  const auto path = scratch.write("a.csv", "old");
  for (const std::size_t bytes : {std::size_t{200}, std::size_t{100'000}}) {
    auto file = PartFile::open(path);
    ASSERT_TRUE(file);
    Result<void> closed;
    {
      const FileSizeLimit full(100);
      const std::string text(bytes, 'x');
      file->check(std::fwrite(text.data(), 1, text.size(), file->get()) == text.size());
      closed = file->close();
    }
    ASSERT_FALSE(closed);
    EXPECT_EQ(closed.error().what, path.string() + ": cannot be written: File too large");
    EXPECT_FALSE(file->is_good());
    EXPECT_EQ(text_of(path), "old");
    EXPECT_EQ(count_files(scratch), 1);
  }
}

TEST(PartFile, TheFirstFailureCounts) {
  const ScratchFolder scratch;
  auto file = PartFile::open(scratch.path() / "a.csv");
  ASSERT_TRUE(file);
  errno = ENOSPC;
  file->check(false);
  errno = EIO;
  file->check(false);
  const auto closed = file->close();
  ASSERT_FALSE(closed);
  EXPECT_THAT(closed.error().what, testing::EndsWith(": No space left on device"));
}

TEST(PartFile, WhatIsNoFileIsWrittenItself) {
  const ScratchFolder scratch;
  const auto link = scratch.path() / "a.csv";
  std::filesystem::create_symlink("/dev/full", link);
  auto file = PartFile::open(link);
  ASSERT_TRUE(file);
  file->check(std::fputs("text", file->get()) >= 0);
  const auto closed = file->close();
  ASSERT_FALSE(closed);
  EXPECT_THAT(closed.error().what, testing::HasSubstr("No space left"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
  EXPECT_TRUE(std::filesystem::is_symlink(link));
}

// This holds also if standard output is a file: a rename would leave the program, and the shell, with the old file.
TEST(PartFile, StandardOutputIsWrittenItself) {
  const ScratchFolder scratch;
  std::fflush(stdout);
  const int output = ::dup(STDOUT_FILENO);
  const int file = ::open((scratch.path() / "out").c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_GE(::dup2(file, STDOUT_FILENO), 0);
  const auto by_name = PartPath("/dev/stdout").part();
  const auto by_number = PartPath("/dev/fd/1").part();
  ::dup2(output, STDOUT_FILENO);
  EXPECT_EQ(by_name, "/dev/stdout");
  EXPECT_EQ(by_number, "/dev/fd/1");
  EXPECT_EQ(PartPath("/dev/stdout").part(), "/dev/stdout");
  for (const int each : {output, file}) ::close(each);
}

TEST(PartFile, AFolderOfThatNameIsReportedInOneLine) {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch.path() / "a.csv" / "in it");
  auto file = PartFile::open(scratch.path() / "a.csv");
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->close());
  const auto kept = file->keep();
  ASSERT_FALSE(kept);
  EXPECT_THAT(kept.error().what, testing::StartsWith("cannot write " + (scratch.path() / "a.csv").string()));
  EXPECT_EQ(count_files(scratch), 1);
  EXPECT_THAT(PartFile::open(scratch.path() / "nowhere" / "a.csv").error().what, testing::HasSubstr("cannot be written: No such file"));
}

}  // namespace
}  // namespace hapton
