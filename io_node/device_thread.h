#pragma once

#include <sys/types.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "core/base/result.h"
#include "io_node/device_loop.h"
#include "runtime/clock.h"
#include "runtime/realtime.h"
#include "runtime/tick_timer.h"

namespace hapton {

// The thread of a device loop. It is one above the network side in SCHED_FIFO: where both share a CPU it is never kept waiting for it.
// RT: start and stop no; the thread is. Threads: one.
class DeviceThread {
 public:
  // Pre: both outlive this.
  DeviceThread(DeviceLoop& loop, const Clock& clock) : loop_(loop), clock_(clock) {}
  ~DeviceThread() { stop(); }
  DeviceThread(const DeviceThread&) = delete;
  DeviceThread& operator=(const DeviceThread&) = delete;

  // Starts the cycles. network: the settings of the network side. Error: real time required and denied, or no timer.
  Result<void> start(const RealtimeSettings& network);
  // Zero on the motors, and the end of the cycles.
  void stop();

  // After start: its thread id, and what it was granted, as in RealtimeReport::to_lines.
  pid_t id() const noexcept { return id_; }
  const std::vector<std::string>& realtime_lines() const noexcept { return realtime_lines_; }

 private:
  void run(const RealtimeSettings& settings);
  void await_tick() noexcept;

  DeviceLoop& loop_;
  const Clock& clock_;
  TickTimer timer_;
  std::thread thread_;
  pid_t id_ = 0;
  std::vector<std::string> realtime_lines_;
  Result<void> started_;
  std::atomic<bool> is_started_{false};
  std::atomic<bool> ends_{false};
};

}  // namespace hapton
