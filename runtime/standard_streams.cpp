#include "runtime/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

namespace hapton {

// open() returns the lowest descriptor that is free, so closed standard streams are filled first.
void open_standard_streams() {
  int opened = 0;
  do {
    opened = ::open("/dev/null", O_RDWR);
  } while (opened >= 0 && opened <= STDERR_FILENO);
  if (opened > STDERR_FILENO) ::close(opened);
}

void outlive_readers() { std::signal(SIGPIPE, SIG_IGN); }

void write_text(std::FILE* to, const std::string& text) { (void)std::fwrite(text.data(), 1, text.size(), to); }

Result<void> flush_standard_output() {
  errno = 0;
  const bool is_flushed = std::fflush(stdout) == 0;
  if (is_flushed && std::ferror(stdout) == 0) return {};
  return fail("the output is not complete: {}; free space on the disk, or choose another file",
              errno != 0 ? std::strerror(errno) : "an earlier part of it could not be written");
}

}  // namespace hapton
