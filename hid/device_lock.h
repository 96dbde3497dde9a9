#pragma once

#include <string>
#include <utility>

#include "core/base/result.h"

namespace hapton {

// The right to drive a device, for one program and one hand in it: the forces of two writers would alternate on one arm. Held from take()
// to destruction, also against another DeviceLock of the same process; the kernel releases it when the process ends. Advisory (flock): it
// stops only programs that take it as well. The watchdog process, which only releases a force, takes no lock. RT: set-up only.
class DeviceLock {
 public:
  DeviceLock() = default;  // holds nothing
  DeviceLock(DeviceLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  DeviceLock& operator=(DeviceLock&&) = delete;
  ~DeviceLock();

  // path: of the device node. Error, one line: another lock is held on it. If the node cannot be opened, the result holds no lock; this is
  // not an error, because opening the device for use will report it.
  static Result<DeviceLock> take(const std::string& path);

 private:
  explicit DeviceLock(int file) : file_(file) {}

  int file_ = -1;
};

}  // namespace hapton
