#include "runtime/writable_path.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <string>

#include "runtime/part_file.h"

namespace hapton {
namespace {

namespace fs = std::filesystem;

bool may_write(const fs::path& path, int how) { return ::access(path.c_str(), how) == 0; }

bool is_broken_link(const fs::path& path) {
  std::error_code error;
  return fs::is_symlink(path, error) && !fs::exists(path, error);
}

fs::path full_path(const fs::path& path) {
  std::error_code error;
  return fs::absolute(path, error).lexically_normal();
}

// The folder itself, or the nearest existing one above it. A broken link on the way up ends the search: no folder can be made through it.
fs::path nearest_existing(const fs::path& folder) {
  std::error_code error;
  fs::path at = full_path(folder);
  while (!fs::exists(at, error) && !is_broken_link(at) && at.has_parent_path() && at != at.parent_path()) at = at.parent_path();
  return at;
}

// Checks the length of the whole path, and of each name in it that does not exist yet: how long a name may be depends on the file system.
// extra_bytes: bytes that the last name has in addition until the file is complete (PartPath).
Result<void> check_lengths(const fs::path& path, std::size_t extra_bytes) {
  const std::size_t size = path.native().size();
  if (size + extra_bytes >= PATH_MAX) {
    return fail("{} cannot be written: it has {} bytes, and {} are the most; give a shorter path", path.string(), size,
                PATH_MAX - 1 - extra_bytes);
  }
  const fs::path full = full_path(path);
  const fs::path existing = nearest_existing(full.parent_path());
  const long longest = ::pathconf(existing.c_str(), _PC_NAME_MAX);  // negative: no limit is known
  const fs::path missing = full.lexically_relative(existing);
  for (auto name = missing.begin(); longest >= 0 && name != missing.end(); ++name) {
    const std::size_t extra_bytes_here = std::next(name) == missing.end() ? extra_bytes : 0;
    if (name->native().size() + extra_bytes_here <= static_cast<std::size_t>(longest)) continue;
    return fail("{} cannot be written: a name in it has {} bytes, and {} are the most; give a shorter one", path.string(),
                name->native().size(), static_cast<std::size_t>(longest) - extra_bytes_here);
  }
  return {};
}

// Makes a folder there and removes it again: permissions alone do not tell, for a network share, for /proc and for a file system that has
// no more room for files.
bool can_create_in(const fs::path& folder) {
  std::string name = (folder / ".hapton-XXXXXX").string();
  return ::mkdtemp(name.data()) != nullptr && ::rmdir(name.c_str()) == 0;
}

// Whether an existing file can be replaced by one that is written beside it (PartPath). A device or a pipe is written directly.
Result<void> check_replaceable(const fs::path& file) {
  const PartPath part(file);
  if (part.part() == file) return {};
  const fs::path folder = part.part().has_parent_path() ? part.part().parent_path() : ".";
  if (can_create_in(folder)) return {};
  return fail("{} cannot be written: nothing can be made in its folder {}: {}; give another place", file.string(), folder.string(),
              std::strerror(errno));
}

}  // namespace

Result<void> check_writable_folder(const fs::path& folder) {
  if (auto fits = check_lengths(folder, 0); !fits) return fits;
  const fs::path existing = nearest_existing(folder);
  if (is_broken_link(existing)) {
    return fail("{} cannot be a folder: the link {} points to something that does not exist; make that, or give another place",
                folder.string(), existing.string());
  }
  std::error_code error;
  if (!fs::is_directory(existing, error)) {
    return fail("{} cannot be a folder: {} is not a folder; give another place", folder.string(), existing.string());
  }
  if (!may_write(existing, W_OK | X_OK) || !can_create_in(existing)) {
    return fail("{} cannot be written: {}: {}; give a folder that may be written to", folder.string(), existing.string(),
                std::strerror(errno));
  }
  return {};
}

Result<void> check_writable_file(const fs::path& file) {
  std::error_code error;
  if (file.filename().empty() || fs::is_directory(file, error)) {
    return fail("{} cannot be written: it is a folder; give the name of a file", file.string());
  }
  const PartPath part(file);
  const fs::path& target = part.target();  // the file to which a link leads
  if (auto fits = check_lengths(target, part.part().native().size() - target.native().size()); !fits) return fits;
  if (!fs::exists(file, error)) {
    const fs::path folder = target.parent_path();
    if (is_broken_link(file) && !folder.empty() && !fs::is_directory(folder, error)) {
      return fail("{} cannot be written: it is a link into {}, which is not an existing folder; make it, or give another name",
                  file.string(), folder.string());
    }
    return check_writable_folder(folder.empty() ? "." : folder);
  }
  if (!may_write(file, W_OK)) return fail("{} cannot be written: {}; give another name", file.string(), std::strerror(errno));
  return check_replaceable(file);
}

bool is_same_output(const fs::path& a, const fs::path& b) {
  if (a.empty() || b.empty()) return false;
  const PartPath parts[] = {PartPath(a), PartPath(b)};
  const auto is_written_itself = [](const PartPath& part) { return part.part() == part.path(); };
  if (std::ranges::any_of(parts, is_written_itself)) return false;
  const auto full = [](const PartPath& part) {
    std::error_code error;
    const fs::path found = fs::weakly_canonical(fs::absolute(part.target(), error), error);
    return error ? full_path(part.target()) : found;
  };
  return full(parts[0]) == full(parts[1]);
}

Result<void> check_different_outputs(const std::vector<NamedOutput>& outputs) {
  for (auto one = outputs.begin(); one != outputs.end(); ++one) {
    for (auto other = std::next(one); other != outputs.end(); ++other) {
      if (!is_same_output(one->file, other->file)) continue;
      return fail("{} and {} are both {}; name two files", one->flag, other->flag, other->file.string());
    }
  }
  return {};
}

}  // namespace hapton
