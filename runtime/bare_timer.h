#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"
#include "runtime/realtime.h"

namespace hapton {

// The timing of a loop that only waits for its ticks: the best that a servo loop can reach on this machine.
struct BareTimer {
  double rate_hz = 0.0;
  std::uint64_t ticks = 0;   // wake-ups
  std::uint64_t missed = 0;  // missed cycles, counted as in a servo loop: whole periods by which a wake-up was late
  LatencyHistogram lateness;

  double missed_share() const noexcept;
  void merge(const BareTimer& other) noexcept;
};

// Runs such a loop on the calling thread. Pre: rate_hz above 0, at most 1e9 (the period is whole ns); seconds finite, above 0.
BareTimer run_bare_timer(Clock& clock, double rate_hz, double seconds) noexcept;

// Runs such a loop in a new thread with these settings, and waits for the result. RT: set-up only. Pre: as above. Error: as enter_realtime.
Result<BareTimer> measure_bare_timer(const RealtimeSettings& settings, double rate_hz, double seconds);

}  // namespace hapton
