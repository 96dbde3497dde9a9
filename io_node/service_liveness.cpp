#include "io_node/service_liveness.h"

#include <algorithm>

namespace hapton {

bool ServiceLiveness::are_ready() const {
  return std::all_of(sessions_.begin(), sessions_.end(), [](const Session& one) { return one.is_ready || one.has_ended; });
}

// A session that has not called note() within the manager's timeout counts as hung.
bool ServiceLiveness::are_alive(std::int64_t now_ns) const {
  return std::all_of(sessions_.begin(), sessions_.end(), [&](const Session& one) {
    return one.has_ended || (one.is_alive && now_ns - one.noted_ns < notify_.manager_timeout_ns());
  });
}

void ServiceLiveness::note(std::size_t session, bool is_alive, std::int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  sessions_[session] = {.is_ready = true, .has_ended = false, .is_alive = is_alive, .noted_ns = now_ns};
  if (!has_notified_ready_ && are_ready()) has_notified_ready_ = notify_.send("READY=1");
  if (notify_.manager_timeout_ns() > 0 && are_alive(now_ns)) notify_.send("WATCHDOG=1");
}

void ServiceLiveness::leave(std::size_t session) {
  const std::lock_guard lock(mutex_);
  sessions_[session].has_ended = true;
}

}  // namespace hapton
