#pragma once

#include <algorithm>
#include <cstdint>

namespace hapton {

// Measures durations of a few nanoseconds and more: reads the CPU's time stamp counter between fences, calibrated against CLOCK_MONOTONIC,
// and subtracts the cost of reading it. Threads: any, each pinned to one CPU while it measures.
class Stopwatch {
 public:
  // Calibrates in two windows of 30 ms each.
  static Stopwatch calibrate();

  // Reads the counter, after all earlier instructions are complete and before a later one starts.
  static std::uint64_t ticks() {
#ifdef __x86_64__
    __builtin_ia32_lfence();
    const std::uint64_t now = __builtin_ia32_rdtsc();
    __builtin_ia32_lfence();
#else
    std::uint64_t now = 0;  // aarch64: the virtual counter
    asm volatile("isb; mrs %0, cntvct_el0; isb" : "=r"(now)::"memory");
#endif
    return now;
  }

  double ns_between(std::uint64_t from, std::uint64_t to) const {
    return std::max(0.0, static_cast<double>(static_cast<std::int64_t>(to - from)) * ns_per_tick_ - cost_ns_);
  }
  double cost_ns() const { return cost_ns_; }              // mean time of an empty measurement; interrupted ones do not count
  double resolution_ns() const { return resolution_ns_; }  // step of the counter: 10 ns on some CPUs
  double drift() const { return drift_; }                  // share by which two calibrations differ: above 0.01 the counter is unreliable

 private:
  double ns_per_tick_ = 1.0;
  double cost_ns_ = 0.0;
  double resolution_ns_ = 0.0;
  double drift_ = 0.0;
};

}  // namespace hapton
