#pragma once

#include <filesystem>
#include <system_error>

#include "tests/support/scratch_folder.h"

namespace hapton {

// While an object of this class exists, the working folder is a folder that has been removed: nobody can write into it, not even root.
class GoneFolder {
 public:
  GoneFolder() : previous_(std::filesystem::current_path()) {
    const ScratchFolder folder;
    std::filesystem::current_path(folder.path());
  }
  ~GoneFolder() {
    std::error_code ignored;
    std::filesystem::current_path(previous_, ignored);
  }
  GoneFolder(const GoneFolder&) = delete;
  GoneFolder& operator=(const GoneFolder&) = delete;

 private:
  std::filesystem::path previous_;
};

}  // namespace hapton
