#include "runtime/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace hapton {
namespace {

// Empty if the file can be read, otherwise the reason why it cannot.
std::string find_obstacle(const struct stat& status, std::size_t max_bytes) {
  if (S_ISDIR(status.st_mode)) return "it is a folder";
  if (!S_ISREG(status.st_mode)) return "it is not a regular file, copy it to one";
  const auto bytes = static_cast<std::size_t>(status.st_size);
  return bytes > max_bytes ? fmt::format("it has {} bytes, more than such a file can have", bytes) : std::string();
}

// Empty if all of it was read, otherwise the reason. A file may grow, or not report its size, as in /proc.
std::string read_all(int file, std::size_t max_bytes, std::string& bytes) {
  struct stat status = {};
  if (fstat(file, &status) != 0) return std::strerror(errno);
  if (std::string obstacle = find_obstacle(status, max_bytes); !obstacle.empty()) return obstacle;
  bytes.reserve(static_cast<std::size_t>(status.st_size));
  std::array<char, 65536> block;
  while (bytes.size() <= max_bytes) {
    const ssize_t read_size = read(file, block.data(), block.size());
    if (read_size == 0) return {};
    if (read_size < 0 && errno == EINTR) continue;
    if (read_size < 0) return std::strerror(errno);
    bytes.append(block.data(), static_cast<std::size_t>(read_size));
  }
  return "it grows while it is read";
}

}  // namespace

Result<std::string> read_regular_file(const std::filesystem::path& path, std::string_view hint, std::size_t max_bytes) {
  // Non-blocking: opening a pipe would wait for a writer.
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return fail("{}: cannot be read: {}; {}", path.string(), std::strerror(errno), hint);
  std::string bytes;
  const std::string obstacle = read_all(file, max_bytes, bytes);
  close(file);
  if (!obstacle.empty()) return fail("{}: cannot be read: {}; {}", path.string(), obstacle, hint);
  return bytes;
}

}  // namespace hapton
