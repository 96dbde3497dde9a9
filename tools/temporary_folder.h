#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/result.h"

namespace hapton {

// A new folder in the temporary folder of the system; it is deleted with this object. RT: no.
class TemporaryFolder {
 public:
  // Makes the folder. Error: one line with the path.
  static Result<TemporaryFolder> make() {
    std::error_code error;
    std::string name = (std::filesystem::temp_directory_path(error) / "hapton-XXXXXX").string();
    if (error || ::mkdtemp(name.data()) == nullptr) return fail("{}: no temporary folder can be made there; set TMPDIR", name);
    return TemporaryFolder(name);
  }
  ~TemporaryFolder() {
    std::error_code error;
    if (!path_.empty()) std::filesystem::remove_all(path_, error);
  }
  TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path path_;
};

}  // namespace hapton
