#pragma once

#include <filesystem>
#include <system_error>

#include "tests/support/scratch_folder.h"

namespace hapton {

// While an object of this class exists, the working folder is one that was removed: nobody can write into it, not even root.
class GoneFolder {
 public:
  GoneFolder() : before_(std::filesystem::current_path()) {
    const ScratchFolder folder;
    std::filesystem::current_path(folder.path());
  }
  ~GoneFolder() {
    std::error_code ignored;
    std::filesystem::current_path(before_, ignored);
  }
  GoneFolder(const GoneFolder&) = delete;
  GoneFolder& operator=(const GoneFolder&) = delete;

 private:
  std::filesystem::path before_;
};

}  // namespace hapton
