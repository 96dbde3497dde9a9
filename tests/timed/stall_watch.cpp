#include "tests/timed/stall_watch.h"

#include <sched.h>

#include "runtime/clock.h"

namespace hapton {

StallWatch::StallWatch() {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  if (::sched_getaffinity(0, sizeof cpus, &cpus) != 0) CPU_SET(0, &cpus);
  std::latch are_started(CPU_COUNT(&cpus));
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &cpus)) threads_.emplace_back([this, cpu, &are_started] { watch_cpu(cpu, are_started); });
  }
  are_started.wait();
}

std::int64_t StallWatch::end() {
  is_ending_ = true;
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  return longest_ns();
}

void StallWatch::watch_cpu(int cpu, std::latch& are_started) {
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(cpu, &only);
  (void)::sched_setaffinity(0, sizeof only, &only);
  const sched_param highest{.sched_priority = ::sched_get_priority_max(SCHED_FIFO)};
  (void)::sched_setscheduler(0, SCHED_FIFO, &highest);
  SteadyClock clock;
  std::int64_t next_ns = clock.now_ns() + kNanosecondsPerMillisecond;
  are_started.count_down();
  for (bool is_last = false; !is_last; next_ns = clock.now_ns() + kNanosecondsPerMillisecond) {
    is_last = is_ending_;
    clock.sleep_until_ns(next_ns);
    const std::int64_t late_ns = clock.now_ns() - next_ns;
    std::int64_t longest_ns = longest_ns_.load();
    while (late_ns > longest_ns && !longest_ns_.compare_exchange_weak(longest_ns, late_ns)) {
    }
  }
}

}  // namespace hapton
