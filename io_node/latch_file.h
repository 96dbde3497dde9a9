#pragma once

#include <filesystem>
#include <string_view>

#include "core/base/result.h"
#include "safety/safety_fault.h"

namespace hapton {

// Keeps the latched fault of a device in a file, so that a restart of the program, by a person or by systemd, does not reset it. The reset
// removes the file, and so do the next boot, a stop of the systemd unit and the user's last logout (find_runtime_folder). A program in
// which the device failed removes the file of the fault `device` at its end, unless a signal ends it. A file that cannot be understood
// counts as `position`: a fault was latched, and which one is unknown. RT: no. Threads: one.
class LatchFile {
 public:
  // An empty path keeps nothing.
  explicit LatchFile(std::filesystem::path file) : file_(std::move(file)) {}

  // none: nothing was latched.
  SafetyFault read() const;
  // Writes the fault to the file, for its owner alone to read. Error: one line; the fault is not kept.
  Result<void> keep(SafetyFault fault) const;
  void forget() const;

  const std::filesystem::path& path() const { return file_; }

 private:
  std::filesystem::path file_;
};

// The file in the runtime folder (find_runtime_folder), named by the device and the hub's address; empty if there is no such folder.
std::filesystem::path find_latch_file(std::string_view device, std::string_view bind);

}  // namespace hapton
