#pragma once

#include "runtime/clock.h"

namespace hapton {

// Waits until `holds` returns true, for half a minute at most. Returns whether it did; how long it took is not part of the result.
template <class Condition>
bool wait_until(Condition&& holds) {
  SteadyClock clock;
  const std::int64_t end_ns = clock.now_ns() + 30 * kNanosecondsPerSecond;
  while (!holds()) {
    if (clock.now_ns() > end_ns) return false;
    clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
  }
  return true;
}

}  // namespace hapton
