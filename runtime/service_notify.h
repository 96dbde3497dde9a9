#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hapton {

// Notifications to the service manager that started the program (systemd, sd_notify(3)). Without one it sends nothing. RT: no.
// Threads: one.
class ServiceNotify {
 public:
  // From NOTIFY_SOCKET and WATCHDOG_USEC.
  ServiceNotify();

  bool has_manager() const noexcept { return !socket_path_.empty(); }
  // The manager's timeout (WatchdogSec): it restarts the program if no WATCHDOG=1 arrives for this long. Send it at half of that or more
  // often. 0: no timeout.
  std::int64_t manager_timeout_ns() const noexcept { return manager_timeout_ns_; }
  // "READY=1", "WATCHDOG=1", "STOPPING=1", "STATUS=..."; false: it could not be sent, as where the manager takes none at present. It does
  // not wait.
  bool send(std::string_view text) const;

 private:
  std::string socket_path_;
  std::int64_t manager_timeout_ns_ = 0;
};

}  // namespace hapton
