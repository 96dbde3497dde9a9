#include "runtime/earlier_file.h"

#include <fcntl.h>
#include <fmt/core.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

namespace hapton {
namespace {

constexpr int kMaxKeptFiles = 100'000;

// Returns 0, or the errno. Never replaces another file, except on a file system without RENAME_NOREPLACE: there, a file that is made at
// `to` between the check and the renaming is lost.
int rename_to_free_name(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  std::error_code error;
  if (std::filesystem::exists(std::filesystem::symlink_status(to, error))) return EEXIST;
  return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

}  // namespace

Result<std::filesystem::path> keep_earlier_file(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error) || std::filesystem::file_size(path, error) == 0 || error) return {};
  const std::filesystem::path file = std::filesystem::canonical(path, error);
  int failure = error.value();
  for (int n = 1; failure == 0 && n <= kMaxKeptFiles; ++n) {
    const std::filesystem::path kept = file.parent_path() / fmt::format("{}-{}{}", file.stem().string(), n, file.extension().string());
    const int code = rename_to_free_name(file, kept);
    if (code == 0) return kept;
    if (code != EEXIST) failure = code;
  }
  return fail("{}: exists and cannot be renamed to keep it: {}; give another name, or move it away", path.string(),
              std::strerror(failure == 0 ? EEXIST : failure));
}

}  // namespace hapton
