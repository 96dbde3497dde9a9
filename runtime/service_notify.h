#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hapton {

// What a program says to the service manager that started it (systemd, sd_notify(3)): nothing where none did.
// RT: no. Threads: one.
class ServiceNotify {
 public:
  // From NOTIFY_SOCKET and WATCHDOG_USEC.
  ServiceNotify();

  bool is_wanted() const noexcept { return !socket_path_.empty(); }
  // How often the manager wants to hear of life at least; 0: not at all.
  std::int64_t watchdog_ns() const noexcept { return watchdog_ns_; }
  // "READY=1", "WATCHDOG=1", "STOPPING=1", "STATUS=..."; false: it did not go out.
  bool send(std::string_view text) const;

 private:
  std::string socket_path_;
  std::int64_t watchdog_ns_ = 0;
};

}  // namespace hapton
