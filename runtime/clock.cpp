#include "runtime/clock.h"

#include <cerrno>
#include <ctime>

namespace hapton {

std::int64_t SteadyClock::now_ns() const noexcept {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNanosecondsPerSecond + now.tv_nsec;
}

void SteadyClock::sleep_until_ns(std::int64_t deadline_ns) noexcept {
  if (deadline_ns <= 0) {
    return;
  }
  timespec deadline = {};
  deadline.tv_sec = deadline_ns / kNanosecondsPerSecond;
  deadline.tv_nsec = deadline_ns % kNanosecondsPerSecond;
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

void SimulatedClock::sleep_until_ns(std::int64_t deadline_ns) noexcept {
  std::int64_t now = now_.load(std::memory_order_acquire);
  while (now < deadline_ns && !now_.compare_exchange_weak(now, deadline_ns, std::memory_order_acq_rel)) {
  }
}

}  // namespace hapton
