#pragma once

#include <string>
#include <utility>

#include "core/base/result.h"

namespace hapton {

// A device is driven by one program, and by one hand of it: two writers would alternate on one arm. Held from take to destruction, also
// against another DeviceLock of the same process; the kernel ends it with the process. Advisory (flock): only those who take it heed it.
// The watchdog process, which only releases a force, takes none. RT: set-up only.
class DeviceLock {
 public:
  DeviceLock() = default;  // holds nothing
  DeviceLock(DeviceLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  DeviceLock& operator=(DeviceLock&&) = delete;
  ~DeviceLock();

  // Error: somebody else holds it; one line. A node that cannot be opened is not locked: opening it for use says why.
  static Result<DeviceLock> take(const std::string& path);

 private:
  explicit DeviceLock(int file) : file_(file) {}

  int file_ = -1;
};

}  // namespace hapton
