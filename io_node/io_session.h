#pragma once

#include <atomic>
#include <string>

#include "core/base/result.h"
#include "io_node/io_options.h"
#include "io_node/servo.h"
#include "runtime/stop_signal.h"

namespace hapton {

// Runs a servo in a thread of its own that keeps time, and does meanwhile what may take long: prints who joins and leaves, writes
// reports, watches for the end.
// RT: no; the servo's thread is. Threads: call from one.
class IoSession {
 public:
  // Pre: all outlive the session.
  IoSession(Servo& servo, const Clock& clock, const IoOptions& options);

  // From the start to the end: seconds over, told to stop, or the device ended. Error: real time required and refused, the device
  // failed, or a report could not be written.
  Result<void> run(StopSignal& stop);

  const std::string& realtime() const noexcept { return realtime_; }

 private:
  void servo_thread();
  bool is_over(const StopSignal& stop) const;
  Result<void> look_after(StopSignal& stop);
  void print_events();
  Result<void> write_report_of(const ServoStats& stats);

  Servo& servo_;
  const Clock& clock_;
  const IoOptions& options_;
  std::string realtime_;
  Result<void> started_;
  std::atomic<bool> is_started_{false};
  std::atomic<bool> ends_{false};
  std::atomic<bool> has_ended_{false};
  std::int64_t end_ns_ = 0;
};

}  // namespace hapton
