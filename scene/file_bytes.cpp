#include "scene/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace hapton {
namespace {

Result<std::string> read_all(int file, const std::string& name, std::size_t max_bytes) {
  struct stat status = {};
  if (fstat(file, &status) != 0) return fail("{}: cannot read: {}", name, std::strerror(errno));
  if (S_ISDIR(status.st_mode)) return fail("{}: is a folder, not a file: name the file in it", name);
  if (!S_ISREG(status.st_mode)) return fail("{}: is not a regular file: copy it to one", name);
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return fail("{}: the file is empty: save, export or copy it again", name);
  if (size > max_bytes) return fail("{}: has {} bytes, more than the {} that can be loaded", name, size, max_bytes);
  std::string bytes(size + 1, '\0');  // one byte more than the file's size, to notice a file that has grown
  std::size_t done = 0;
  while (done <= size) {
    const ssize_t got = read(file, bytes.data() + done, size + 1 - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail("{}: cannot read: {}", name, std::strerror(errno));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  if (done != size) return fail("{}: got {} while it was read: try again", name, done < size ? "shorter" : "longer");
  bytes.resize(size);
  return bytes;
}

}  // namespace

Result<std::string> read_file_bytes(const std::filesystem::path& path, std::size_t max_bytes) {
  // Not blocking, so that a pipe without a writer is rejected rather than waited for.
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) {
    if (path.empty()) return fail("no file is named: give its path");
    if (errno == ENOENT) return fail("{}: no such file: check the path", path.string());
    return fail("{}: cannot open: {}", path.string(), std::strerror(errno));
  }
  Result<std::string> bytes = read_all(file, path.string(), max_bytes);
  close(file);
  return bytes;
}

}  // namespace hapton
