#pragma once

#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include "tests/fuzz/fuzz_target.h"
#include "tests/support/scratch_folder.h"

namespace hapton::fuzz {

// Writes bytes to a file, for code that only reads files.
class InputFile {
 public:
  explicit InputFile(std::string name) : name_(std::move(name)) {}

  std::filesystem::path write(std::span<const std::uint8_t> bytes) {
    return folder_.write(name_, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  const ScratchFolder& folder() const { return folder_; }

 private:
  std::string name_;
  ScratchFolder folder_;
};

}  // namespace hapton::fuzz
