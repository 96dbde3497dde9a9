#include "runtime/writable_path.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "runtime/part_file.h"

namespace hapton {
namespace {

namespace fs = std::filesystem;

bool may_write(const fs::path& path, int how) { return ::access(path.c_str(), how) == 0; }

// The folder itself, or the nearest one above it that is there.
fs::path nearest_there(const fs::path& folder) {
  std::error_code error;
  fs::path at = fs::absolute(folder, error).lexically_normal();
  while (!fs::exists(at, error) && at.has_parent_path() && at != at.parent_path()) at = at.parent_path();
  return at;
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
  const fs::path there = nearest_there(folder);
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
  if (!fs::exists(file, error)) {
    const fs::path folder = PartPath(file).part().parent_path();  // of what a link leads to
    return check_writable_folder(folder.empty() ? "." : folder);
  }
  if (!may_write(file, W_OK)) return fail("{} cannot be written: {}; give another name", file.string(), std::strerror(errno));
  return check_replaceable(file);
}

}  // namespace hapton
