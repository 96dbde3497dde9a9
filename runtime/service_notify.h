#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hapton {

// Notifications to the service manager that started the program (systemd, sd_notify(3)). Without a manager nothing is sent. RT: no.
// Threads: one.
class ServiceNotify {
 public:
  // Reads NOTIFY_SOCKET and WATCHDOG_USEC.
  ServiceNotify();

  bool has_manager() const noexcept { return !socket_path_.empty(); }
  // The manager's timeout (WatchdogSec): it restarts the program if no WATCHDOG=1 arrives for this long. Send WATCHDOG=1 at least twice in
  // this time. 0: no timeout.
  std::int64_t manager_timeout_ns() const noexcept { return manager_timeout_ns_; }
  // Sends "READY=1", "WATCHDOG=1", "STOPPING=1", "STATUS=...", without waiting. False: it was not sent, because there is no manager, or
  // because the manager does not take it now.
  bool send(std::string_view text) const;

 private:
  std::string socket_path_;
  std::int64_t manager_timeout_ns_ = 0;
};

}  // namespace hapton
