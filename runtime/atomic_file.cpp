#include "runtime/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

#include "runtime/part_file.h"

namespace hapton {
namespace {

tl::unexpected<Error> fail_to_write(const std::filesystem::path& path, int error) {
  return fail("cannot write {}: {}; check the permissions and the free space of its folder, or choose another one", path.string(),
              std::strerror(error));
}

// Returns 0, or the errno of the first call that failed. That may be fclose: some errors are reported only there.
int write_text(const std::filesystem::path& path, std::string_view text, FileReaders readers) {
  std::FILE* file = open_file_for(path, readers);
  if (file == nullptr) {
    return errno;
  }
  int error = std::fwrite(text.data(), 1, text.size(), file) == text.size() ? 0 : errno;
  if (std::fclose(file) != 0 && error == 0) {
    error = errno;
  }
  return error;
}

}  // namespace

std::FILE* open_file_for(const std::filesystem::path& path, FileReaders readers) {
  const bool is_private = readers == FileReaders::owner;
  // Non-blocking only for open() itself, which would otherwise wait for a reader of a pipe.
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, is_private ? 0600 : 0666);
  if (file < 0) return nullptr;
  (void)::fcntl(file, F_SETFL, O_WRONLY);
  if (is_private) (void)::fchmod(file, 0600);  // fails for another user's file, such as a device, which keeps its mode
  std::FILE* const stream = ::fdopen(file, "wb");
  if (stream == nullptr) {
    const int error = errno;
    ::close(file);
    errno = error;
  }
  return stream;
}

Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text, FileReaders readers) {
  std::error_code error;
  if (path.has_parent_path()) {
    std::filesystem::create_directories(path.parent_path(), error);
    if (error) {
      return fail_to_write(path, error.value());
    }
  }
  PartPath part(path);
  if (const int failure = write_text(part.part(), text, readers); failure != 0) return fail_to_write(path, failure);
  return part.keep();
}

}  // namespace hapton
