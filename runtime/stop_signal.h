#pragma once

#include <cstdint>

namespace hapton {

// Turns SIGINT and SIGTERM into a flag to look at, and SIGUSR1 into a request for a report. Interrupted system calls start again, so a loop
// sees the flag at its next turn; a second SIGINT or SIGTERM ends the process the hard way. One per process: the handlers stay until it is
// destroyed. RT: the readers yes. Threads: any.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool stop_requested() const noexcept;
  // The same request from inside the program.
  void request_stop() noexcept;
  // How many SIGUSR1 have come: whoever reports does so when it has risen.
  std::uint32_t report_requests() const noexcept;
};

}  // namespace hapton
