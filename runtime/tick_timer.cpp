#include "runtime/tick_timer.h"

#include <sys/timerfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "runtime/clock.h"

namespace hapton {

TickTimer::~TickTimer() {
  if (file_ >= 0) ::close(file_);
}

Result<void> TickTimer::open() {
  file_ = ::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC);
  if (file_ < 0) return fail("cannot create a timer: {}; allow the process more open files (ulimit -n, LimitNOFILE)", std::strerror(errno));
  return {};
}

void TickTimer::set(std::int64_t time_ns) noexcept {
  const itimerspec once = {.it_interval = {},
                           .it_value = {.tv_sec = time_ns / kNanosecondsPerSecond, .tv_nsec = time_ns % kNanosecondsPerSecond}};
  is_set_ = ::timerfd_settime(file_, TFD_TIMER_ABSTIME, &once, nullptr) == 0;
}

void TickTimer::wait() noexcept {
  if (!is_set_) return;
  is_set_ = false;
  std::uint64_t expirations = 0;
  while (::read(file_, &expirations, sizeof expirations) < 0 && errno == EINTR) {
  }
}

}  // namespace hapton
