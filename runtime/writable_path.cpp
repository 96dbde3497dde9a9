#include "runtime/writable_path.h"

#include <unistd.h>

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

// The folder itself, or the nearest one above it that is there; or a link that leads nowhere, through which no folder can be made.
fs::path nearest_there(const fs::path& folder) {
  std::error_code error;
  fs::path at = full_path(folder);
  while (!fs::exists(at, error) && !is_broken_link(at) && at.has_parent_path() && at != at.parent_path()) at = at.parent_path();
  return at;
}

// Of the last name, and of the folders that are still to be made: some file systems take fewer bytes in a name than others. added: bytes
// that the last name gets until the file is complete.
Result<void> check_lengths(const fs::path& path, std::size_t added) {
  const std::size_t size = path.native().size();
  if (size + added >= PATH_MAX) {
    return fail("{} cannot be written: it has {} bytes, and {} are the most; give a shorter path", path.string(), size,
                PATH_MAX - 1 - added);
  }
  const fs::path full = full_path(path);
  const fs::path there = nearest_there(full.parent_path());
  const long longest = ::pathconf(there.c_str(), _PC_NAME_MAX);  // below 0: no limit is known
  const fs::path below = full.lexically_relative(there);
  for (auto name = below.begin(); longest >= 0 && name != below.end(); ++name) {
    const std::size_t with = std::next(name) == below.end() ? added : 0;
    if (name->native().size() + with <= static_cast<std::size_t>(longest)) continue;
    return fail("{} cannot be written: a name in it has {} bytes, and {} are the most; give a shorter one", path.string(),
                name->native().size(), static_cast<std::size_t>(longest) - with);
  }
  return {};
}

// By making a folder in it and removing it: permissions alone say too little of a share on the network, of /proc or of a full table of
// files.
bool can_make_in(const fs::path& folder) {
  std::string name = (folder / ".hapton-XXXXXX").string();
  return ::mkdtemp(name.data()) != nullptr && ::rmdir(name.c_str()) == 0;
}

// Beside a file that is there: it is written under another name and then replaced. A device or a pipe is written itself.
Result<void> check_replaceable(const fs::path& file) {
  const PartPath part(file);
  if (part.part() == file) return {};
  const fs::path folder = part.part().has_parent_path() ? part.part().parent_path() : ".";
  if (can_make_in(folder)) return {};
  return fail("{} cannot be written: nothing can be made in its folder {}: {}; give another place", file.string(), folder.string(),
              std::strerror(errno));
}

}  // namespace

Result<void> check_writable_folder(const fs::path& folder) {
  if (auto fits = check_lengths(folder, 0); !fits) return fits;
  const fs::path there = nearest_there(folder);
  if (is_broken_link(there)) {
    return fail("{} cannot be a folder: the link {} leads to nothing; make what it leads to, or give another place", folder.string(),
                there.string());
  }
  std::error_code error;
  if (!fs::is_directory(there, error)) {
    return fail("{} cannot be a folder: {} is not a folder; give another place", folder.string(), there.string());
  }
  if (!may_write(there, W_OK | X_OK) || !can_make_in(there)) {
    return fail("{} cannot be written: {}: {}; give a folder that may be written to", folder.string(), there.string(),
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
  const fs::path& target = part.target();  // what a link leads to
  if (auto fits = check_lengths(target, part.part().native().size() - target.native().size()); !fits) return fits;
  if (!fs::exists(file, error)) {
    const fs::path folder = target.parent_path();
    if (is_broken_link(file) && !folder.empty() && !fs::is_directory(folder, error)) {
      return fail("{} cannot be written: it leads into {}, which is not a folder that is there; make it, or give another name",
                  file.string(), folder.string());
    }
    return check_writable_folder(folder.empty() ? "." : folder);
  }
  if (!may_write(file, W_OK)) return fail("{} cannot be written: {}; give another name", file.string(), std::strerror(errno));
  return check_replaceable(file);
}

}  // namespace hapton
