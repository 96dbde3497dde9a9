#pragma once

#include <cstdint>

namespace hapton {

// Turns SIGINT and SIGTERM into a flag to poll, and SIGUSR1 into a request for a report. Blocking reads and writes restart; poll and sleeps
// return EINTR. A loop sees the flag in its next turn; a second SIGINT or SIGTERM kills the process. One per process: the handlers stay
// until it is destroyed. RT: the readers yes. Threads: any.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool stop_requested() const noexcept;
  // The same request from inside the program; the next SIGINT or SIGTERM then kills the process.
  void request_stop() noexcept;
  // How many SIGUSR1 have come: report when it has increased.
  std::uint32_t report_requests() const noexcept;
};

}  // namespace hapton
