#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hapton {

// Notifications to the service manager that started the program (systemd, sd_notify(3)); none without one. RT: no. Threads:
// one.
class ServiceNotify {
 public:
  // From NOTIFY_SOCKET and WATCHDOG_USEC.
  ServiceNotify();

  bool is_wanted() const noexcept { return !socket_path_.empty(); }
  // The interval at which the manager expects a WATCHDOG=1; 0: never.
  std::int64_t watchdog_ns() const noexcept { return watchdog_ns_; }
  // "READY=1", "WATCHDOG=1", "STOPPING=1", "STATUS=..."; false: it could not be sent.
  bool send(std::string_view text) const;

 private:
  std::string socket_path_;
  std::int64_t watchdog_ns_ = 0;
};

}  // namespace hapton
