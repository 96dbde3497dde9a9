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

// The thread of a device loop. Its SCHED_FIFO priority is one above that of the network side's thread (at most 99), so that
// it never waits for that thread if both use one CPU. RT: start and stop set-up only; the thread is real-time. Threads: one.
class DeviceThread {
 public:
  // Pre: loop and clock outlive this.
  DeviceThread(DeviceLoop& loop, const Clock& clock) : loop_(loop), clock_(clock) {}
  ~DeviceThread() { stop(); }
  DeviceThread(const DeviceThread&) = delete;
  DeviceThread& operator=(const DeviceThread&) = delete;

  // Starts the cycles. network: the settings of the network side's thread. Error: real time is required and was denied, or there is no
  // timer.
  Result<void> start(const RealtimeSettings& network);
  // Ends the cycles, and then writes zero force to the motors. Has no effect if the thread does not run.
  void stop();

  // The thread's id, and which real-time settings the system granted it (RealtimeReport::to_lines). Pre: start() succeeded.
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
