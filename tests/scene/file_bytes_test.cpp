#include "scene/file_bytes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <string>
#include <thread>

#include "tests/support/open_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST(FileBytes, GivesAllOfAFile) {
  const ScratchFolder folder;
  const std::string bytes("a\0b\n", 4);
  const auto read = read_file_bytes(folder.write("a", bytes), 4);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(*read, bytes);
}

TEST(FileBytes, RejectsWithTheReason) {
  const ScratchFolder folder;
  EXPECT_THAT(read_file_bytes(folder.write("a", "12345"), 4).error().what, HasSubstr("5 bytes, more than the 4"));
  EXPECT_THAT(read_file_bytes(folder.write("b", ""), 4).error().what, HasSubstr("empty"));
  EXPECT_THAT(read_file_bytes(folder.path(), 4).error().what, HasSubstr("is a folder"));
  EXPECT_THAT(read_file_bytes(folder.path() / "c", 4).error().what, HasSubstr("no such file"));
  EXPECT_THAT(read_file_bytes("", 4).error().what, HasSubstr("no file is named"));
  EXPECT_THAT(read_file_bytes(folder.path() / "a" / "b", 4).error().what, HasSubstr("cannot open"));
  EXPECT_THAT(read_file_bytes("/dev/zero", 4).error().what, HasSubstr("not a regular file"));
  std::filesystem::create_symlink("loop", folder.path() / "loop");
  EXPECT_THAT(read_file_bytes(folder.path() / "loop", 4).error().what, HasSubstr("cannot open"));
}

// The first half of a mesh file may itself be a valid file, so a file that is still growing must be rejected.
TEST(FileBytes, RejectsAFileThatIsStillBeingWritten) {
  constexpr int kMaxReads = 2000;  // each takes a few ms, long enough for the other thread to write something if it runs at all
  const ScratchFolder folder;
  const auto path = folder.write("a", std::string(std::size_t{1} << 22, 'x'));
  std::atomic<bool> has_ended = false;
  std::thread writer([&] {
    std::ofstream file(path, std::ios::binary | std::ios::app);
    while (!has_ended) file.put('x').flush();
  });
  std::string error;
  for (int i = 0; i < kMaxReads && error.empty(); ++i) {
    const auto read = read_file_bytes(path, std::size_t{1} << 30);
    if (!read) error = read.error().what;
  }
  has_ended = true;
  writer.join();
  EXPECT_THAT(error, HasSubstr("got longer while it was read: try again"));
  EXPECT_TRUE(read_file_bytes(path, std::size_t{1} << 30));
}

TEST(FileBytes, IsClosedAgain) {
  const ScratchFolder folder;
  const auto path = folder.write("a", "12345");
  EXPECT_FALSE(leaves_files_open([&] {
    EXPECT_TRUE(read_file_bytes(path, 5));
    EXPECT_FALSE(read_file_bytes(path, 4));
  }));
}

}  // namespace
}  // namespace hapton
