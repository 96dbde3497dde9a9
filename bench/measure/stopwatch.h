#pragma once

#include <algorithm>
#include <cstdint>

namespace hapton {

// Times stretches of a few nanoseconds: the CPU's time stamp counter between fences, calibrated against CLOCK_MONOTONIC, what reading it
// costs taken off. Threads: any, pinned to one CPU while it measures.
class Stopwatch {
 public:
  // Takes some 60 ms.
  static Stopwatch calibrate();

  // All earlier instructions are complete, no later one has started.
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
  double cost_ns() const { return cost_ns_; }              // mean of reading it twice, interruptions left out
  double resolution_ns() const { return resolution_ns_; }  // the counter moves in steps of this; some CPUs' of 10 ns
  double drift() const { return drift_; }  // share by which two calibrations differ: above 0.01 the counter is not to be trusted

 private:
  double ns_per_tick_ = 1.0;
  double cost_ns_ = 0.0;
  double resolution_ns_ = 0.0;
  double drift_ = 0.0;
};

}  // namespace hapton
