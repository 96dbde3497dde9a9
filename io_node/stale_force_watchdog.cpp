#include "io_node/stale_force_watchdog.h"

#include <pthread.h>

#include "runtime/deadline_thread.h"
#include "runtime/start_thread.h"

namespace hapton {

void StaleForceWatchdog::start(bool is_realtime) {
  thread_ = start_thread([this, is_realtime] {
    ::pthread_setname_np(::pthread_self(), "hapton-release");
    if (is_realtime) (void)enter_deadline(kRuntimeNs, kPeriodNs);
    SteadyClock clock;
    while (!ends_.load(std::memory_order_acquire)) clock.sleep_until_ns(check());
  });
}

void StaleForceWatchdog::stop() {
  ends_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

// Later forces reply to later samples, so the present force is the first that can become too old.
std::int64_t StaleForceWatchdog::check() noexcept {
  (void)loop_.cut_if_older(kLimitNs);
  const std::int64_t now_ns = clock_.now_ns();
  const std::int64_t sample_ns = loop_.force_sample_ns();
  const std::int64_t due_ns = sample_ns + kLimitNs;
  return sample_ns != 0 && due_ns > now_ns ? due_ns : now_ns + kIdleNs;
}

}  // namespace hapton
