#pragma once

#include <cstdint>

#include "core/base/result.h"

namespace hapton {

// A timer that is set at one moment and waited for at another: a loop sets the next wake-up before the work that must not be delayed, and
// then only blocks. Units: ns of CLOCK_MONOTONIC. RT: yes, each call is one system call; open is for set-up only. Threads: one.
class TickTimer {
 public:
  TickTimer() = default;
  ~TickTimer();
  TickTimer(const TickTimer&) = delete;
  TickTimer& operator=(const TickTimer&) = delete;

  // Error: the process has no descriptor left, one line.
  Result<void> open();

  // Pre: open; time_ns > 0. A time that has passed ends the next wait at once.
  void set(std::int64_t time_ns) noexcept;
  // Blocks until the time set last; returns at once if that time has been waited for already, or none was set.
  void wait() noexcept;

 private:
  int file_ = -1;
  bool is_set_ = false;
};

}  // namespace hapton
