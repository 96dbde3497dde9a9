#pragma once

namespace hapton {

// Turns SIGINT and SIGTERM into a flag to look at, and SIGUSR1 into a wish for a report. Interrupted system calls start again, so a loop
// sees the flag at its next turn; a second SIGINT or SIGTERM ends the process the hard way. One per process: the handlers stay until it is
// destroyed. RT: the readers yes. Threads: any.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool stop_requested() const noexcept;
  // The same wish from inside the program.
  void request_stop() noexcept;
  // True once for each SIGUSR1 (several before a look count as one).
  bool take_report_request() noexcept;
};

}  // namespace hapton
