// Component runtime alone: a histogram of how late the clock ends a sleep.
#include <cstdio>

#include "runtime/clock.h"
#include "runtime/latency_histogram.h"

int main() {
  using namespace hapton;
  SteadyClock clock;
  LatencyHistogram late;
  std::int64_t next_ns = clock.now_ns();
  for (int k = 0; k < 100; ++k) {
    clock.sleep_until_ns(next_ns += kNanosecondsPerMillisecond);
    late.record(clock.now_ns() - next_ns);
  }
  std::printf("%llu wake-ups\n", static_cast<unsigned long long>(late.count()));
  return late.count() == 100 ? 0 : 1;
}
