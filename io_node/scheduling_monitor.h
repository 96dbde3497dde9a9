#pragma once

#include <cstdint>
#include <optional>

#include "runtime/thread_usage.h"

namespace hapton {

// How a loop spent its time, as shares of the whole, and how the system scheduled it.
struct SchedulingStats {
  bool is_known = false;
  double worked_share = 0.0;
  double spun_share = 0.0;
  double slept_share = 0.0;
  double waited_ms = 0.0;  // ready to run, but kept waiting for a CPU
  std::uint64_t involuntary_switches = 0;
  double stolen_ms = 0.0;             // CPU time that a hypervisor took from the machine
  double spin_limit = 0.0;            // share of a period that it may spin now
  double realtime_share = 1.0;        // the kernel's limit for all real-time threads together
  std::uint64_t near_throttling = 0;  // checks that found the loop near that limit
};

// Monitors a loop from another thread, a few times a second, and limits how much it may spin: work and spinning together stay well below
// the kernel's limit for real-time threads, so that the loop is never throttled. RT: no. Threads: one, not the loop's.
class SchedulingMonitor {
 public:
  // Share of the kernel's limit that work and spinning together may use.
  static constexpr double kMaxUsedShare = 0.8;
  // At this share of the kernel's limit, or above, the loop is about to be throttled.
  static constexpr double kNearThrottlingShare = 0.95;

  // requested_spin_share: largest share of a period that may be spun. realtime_share: see read_realtime_share.
  SchedulingMonitor(double requested_spin_share, std::optional<double> realtime_share);

  // usage, spun_ns: totals of the loop's threads so far. Returns the largest share of a period that the loop may spin from now on.
  double update(const ThreadUsage& usage, std::int64_t spun_ns, std::int64_t now_ns);

  const SchedulingStats& stats() const { return stats_; }
  // Whether the last update() was the first that found the loop near the kernel's limit.
  bool has_come_near_throttling() const { return has_come_near_; }

 private:
  struct Reading {
    ThreadUsage usage;
    std::int64_t spun_ns = 0;
    std::int64_t now_ns = 0;
  };

  double requested_spin_share_;
  std::optional<Reading> first_;
  std::optional<Reading> last_;
  SchedulingStats stats_;
  bool has_come_near_ = false;
};

}  // namespace hapton
