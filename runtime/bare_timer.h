#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"
#include "runtime/realtime.h"

namespace hapton {

// The timing of a loop that only waits for its ticks: the yardstick for every servo loop on this machine.
struct BareTimer {
  double rate_hz = 0.0;
  std::uint64_t ticks = 0;   // woken for
  std::uint64_t missed = 0;  // cycles slept through, counted as in a servo loop: late by whole periods
  LatencyHistogram lateness;

  double missed_share() const noexcept;
  void merge(const BareTimer& other) noexcept;
};

// The bare loop on the calling thread. Pre: rate_hz and seconds finite, above 0.
BareTimer run_bare_timer(Clock& clock, double rate_hz, double seconds) noexcept;

// The same in its own thread, scheduled by the settings; waits for it. RT: set-up only. Error: see enter_realtime.
Result<BareTimer> measure_bare_timer(const RealtimeSettings& settings, double rate_hz, double seconds);

}  // namespace hapton
