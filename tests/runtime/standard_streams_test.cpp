#include "runtime/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/file_size_limit.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using testing::ExitedWithCode;

// Runs in a child process. Exit code 0: the file did not get the number of a standard stream, and the output streams can be written.
[[noreturn]] void open_a_file_without(std::initializer_list<int> closed) {
  for (const int stream : closed) ::close(stream);
  open_standard_streams();
  const int file = ::open("/dev/zero", O_RDONLY);
  const bool is_writable = ::write(STDOUT_FILENO, "", 0) == 0 && ::write(STDERR_FILENO, "", 0) == 0;
  _exit(file > STDERR_FILENO && is_writable ? 0 : 1);
}

TEST(StandardStreams, NoFileTakesThePlaceOfAClosedOne) {
  EXPECT_EXIT(open_a_file_without({}), ExitedWithCode(0), "");
  EXPECT_EXIT(open_a_file_without({STDIN_FILENO}), ExitedWithCode(0), "");
  EXPECT_EXIT(open_a_file_without({STDOUT_FILENO}), ExitedWithCode(0), "");
  EXPECT_EXIT(open_a_file_without({STDERR_FILENO}), ExitedWithCode(0), "");
  EXPECT_EXIT(open_a_file_without({STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}), ExitedWithCode(0), "");
}

// Prints `bytes` bytes to a disk that is full. Exit code 7: the loss was noticed.
[[noreturn]] void print_to_full_disk(int bytes) {
  if (std::freopen("/dev/full", "w", stdout) == nullptr) _exit(1);
  for (int n = 0; n < bytes; ++n) std::fputc('x', stdout);
  const auto flushed = flush_standard_output();
  if (flushed) _exit(0);
  std::fprintf(stderr, "%s\n", flushed.error().what.c_str());
  _exit(7);
}

// The disk is full for a while, and has room again when the rest is written. Exit code 7: the loss was noticed.
[[noreturn]] void print_to_disk_that_was_full(const char* file) {
  static char small_buffer[16];
  if (std::freopen(file, "w", stdout) == nullptr || std::setvbuf(stdout, small_buffer, _IOFBF, sizeof small_buffer) != 0) _exit(1);
  {
    const FileSizeLimit full(4);
    for (int n = 0; n < 64; ++n) std::fputc('x', stdout);
  }
  _exit(flush_standard_output() ? 0 : 7);
}

// Prints to a stream without a buffer, like stderr. Exit code 0: the process went on.
[[noreturn]] void print_without_a_reader() {
  int ends[2];
  if (::pipe(ends) != 0 || ::close(ends[0]) != 0) _exit(1);
  std::FILE* const stream = ::fdopen(ends[1], "w");
  if (stream == nullptr || std::setvbuf(stream, nullptr, _IONBF, 0) != 0) _exit(1);
  outlive_readers();
  print_text(stream, "released the force after {} ms\n", 20);
  _exit(0);
}

TEST(StandardStreams, WhoPrintsOutlivesWhoReads) { EXPECT_EXIT(print_without_a_reader(), ExitedWithCode(0), ""); }

TEST(StandardStreams, OutputThatDoesNotArriveIsAnError) {
  EXPECT_TRUE(flush_standard_output());
  EXPECT_EXIT(print_to_full_disk(0), ExitedWithCode(0), "");
  EXPECT_EXIT(print_to_full_disk(10), ExitedWithCode(7), "the output is not complete: No space left on device");
  EXPECT_EXIT(print_to_full_disk(100'000), ExitedWithCode(7), "the output is not complete: ");
  const ScratchFolder scratch;
  EXPECT_EXIT(print_to_disk_that_was_full((scratch.path() / "out").c_str()), ExitedWithCode(7), "");
}

}  // namespace
}  // namespace hapton
