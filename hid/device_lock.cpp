#include "hid/device_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>

namespace hapton {

DeviceLock::~DeviceLock() {
  if (file_ >= 0) ::close(file_);
}

Result<DeviceLock> DeviceLock::take(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return DeviceLock();
  DeviceLock lock(file);
  if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return fail("{}: another io_node, or another hand of this one, drives it; end that one, or choose another device (--device-id)", path);
  }
  return lock;
}

}  // namespace hapton
