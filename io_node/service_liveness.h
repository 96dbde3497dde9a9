#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "runtime/service_notify.h"

namespace hapton {

// Tells the service manager that the program is ready once all of its sessions are ready, and that it lives as long as all of them live: so
// the manager restarts the program if the device loop of any session hangs. RT: no. Threads: any.
class ServiceLiveness {
 public:
  explicit ServiceLiveness(std::size_t sessions) : sessions_(sessions) {}

  bool has_manager() const noexcept { return notify_.has_manager(); }
  std::int64_t manager_timeout_ns() const noexcept { return notify_.manager_timeout_ns(); }

  // Each session calls this from the time when it is ready, at least twice in the manager's timeout, until it leaves. is_alive: its device
  // loop runs. Pre: session < the number of sessions.
  void note(std::size_t session, bool is_alive, std::int64_t now_ns);
  // The session has ended: it is ignored from now on.
  void leave(std::size_t session);

 private:
  struct Session {
    bool is_ready = false;
    bool has_ended = false;
    bool is_alive = false;
    std::int64_t noted_ns = 0;
  };
  bool are_ready() const;
  bool are_alive(std::int64_t now_ns) const;

  ServiceNotify notify_;
  std::mutex mutex_;
  std::vector<Session> sessions_;
  bool has_notified_ready_ = false;
};

}  // namespace hapton
