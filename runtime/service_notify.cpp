#include "runtime/service_notify.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace hapton {

ServiceNotify::ServiceNotify() {
  if (const char* path = std::getenv("NOTIFY_SOCKET"); path != nullptr && std::strlen(path) < sizeof(sockaddr_un::sun_path)) {
    socket_path_ = path;
  }
  if (const char* period = std::getenv("WATCHDOG_USEC"); period != nullptr) {
    std::int64_t period_us = 0;
    const auto read = std::from_chars(period, period + std::strlen(period), period_us);
    if (read.ec == std::errc() && period_us > 0) manager_timeout_ns_ = period_us * 1000;
  }
}

bool ServiceNotify::send(std::string_view text) const {
  if (socket_path_.empty()) return false;
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return false;
  sockaddr_un to = {};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, socket_path_.data(), socket_path_.size());
  if (to.sun_path[0] == '@') to.sun_path[0] = '\0';  // the address of an abstract socket begins with a zero byte
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_path_.size());
  // A service manager that hangs must not block the caller, which has other work to do.
  constexpr int kFlags = MSG_NOSIGNAL | MSG_DONTWAIT;
  const bool is_sent =
      ::sendto(socket, text.data(), text.size(), kFlags, reinterpret_cast<const sockaddr*>(&to), size) == static_cast<ssize_t>(text.size());
  ::close(socket);
  return is_sent;
}

}  // namespace hapton
