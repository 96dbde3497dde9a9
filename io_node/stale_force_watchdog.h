#pragma once

#include <atomic>
#include <thread>

#include "io_node/device_loop.h"
#include "runtime/clock.h"

namespace hapton {

// The second of three barriers against an old force, between DeviceLoop and the watchdog process: a thread that cuts the device if its
// force gets older than the device loop permits. It sleeps until the present force would be too old: fifty wake-ups a second, and two
// hundred while there is no force. Unlike the device loop it does not run under SCHED_FIFO: the kernel throttles all such threads of a CPU
// together, and one that never sleeps starves all others (docs/realtime.md). It requests SCHED_DEADLINE, which has priority over them and
// is not throttled; if that is denied it stays an ordinary thread, which runs when they are throttled. RT: no. Threads: one; device_loop.h
// explains why another thread may cut.
class StaleForceWatchdog {
 public:
  // Half a cycle of 1 kHz later than the loop itself releases the force.
  static constexpr std::int64_t kLimitNs = kCommandTimeoutNs + 500'000;
  // Between two checks while there is no force: the next force may already be old when it arrives.
  static constexpr std::int64_t kIdleNs = 5 * kNanosecondsPerMillisecond;
  // For SCHED_DEADLINE: a check takes 2 us, a cut through a vendor's library more.
  static constexpr std::int64_t kRuntimeNs = 50'000;
  static constexpr std::int64_t kPeriodNs = 500'000;

  // Pre: both outlive this.
  StaleForceWatchdog(DeviceLoop& loop, const Clock& clock) : loop_(loop), clock_(clock) {}
  ~StaleForceWatchdog() { stop(); }
  StaleForceWatchdog(const StaleForceWatchdog&) = delete;
  StaleForceWatchdog& operator=(const StaleForceWatchdog&) = delete;

  // is_realtime: requests SCHED_DEADLINE.
  void start(bool is_realtime);
  void stop();

  // Checks once, and cuts the device if its force is too old. Returns the time of the next check.
  std::int64_t check() noexcept;

 private:
  DeviceLoop& loop_;
  const Clock& clock_;
  std::thread thread_;
  std::atomic<bool> ends_{false};
};

}  // namespace hapton
