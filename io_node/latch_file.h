#pragma once

#include <filesystem>
#include <string_view>

#include "core/base/result.h"
#include "safety/safety_fault.h"

namespace hapton {

// Keeps the latched fault of a device in a file, so that a restart of the program, by a person or by systemd, does not reset it. The reset
// removes the file, and so do the next boot, a stop of the systemd unit and the user's last logout (find_runtime_folder). A file that
// cannot be understood counts as `position`: a fault was latched, and which one is unknown. RT: no. Threads: one.
class LatchFile {
 public:
  // An empty path keeps nothing.
  explicit LatchFile(std::filesystem::path file) : file_(std::move(file)) {}

  // none: nothing was latched.
  SafetyFault read() const;
  // For the user alone. Error: one line, it is not kept.
  Result<void> keep(SafetyFault fault) const;
  void forget() const;

  const std::filesystem::path& path() const { return file_; }

 private:
  std::filesystem::path file_;
};

// In the runtime folder (find_runtime_folder), by device and by where its hub listens; empty when there is no such folder.
std::filesystem::path find_latch_file(std::string_view device, std::string_view bind);

}  // namespace hapton
