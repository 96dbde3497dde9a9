#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <sys/types.h>

namespace hapton {

// Kernel statistics of a thread since it started, and one of the machine.
struct ThreadUsage {
  double run_s = 0.0;     // on a CPU
  double waited_s = 0.0;  // ready to run, but kept waiting for a CPU
  std::uint64_t voluntary_switches = 0;
  std::uint64_t involuntary_switches = 0;  // another thread took its CPU
  double stolen_s = 0.0;                   // of the whole machine since it booted: time that a hypervisor kept from it
};

// The calling thread's number, for read_thread_usage. RT: set-up only.
pid_t current_thread_id();

// The statistics of a thread of this process, from /proc; empty if the thread has ended or the system provides nothing. RT: no.
std::optional<ThreadUsage> read_thread_usage(pid_t thread);

// The share of a CPU's time that the kernel gives real-time threads, 0 to 1 (sched_rt_runtime_us over sched_rt_period_us); 1: all of it;
// empty if unknown. Real-time threads that use more of a CPU are stopped for the rest of each period. RT: no.
std::optional<double> read_realtime_share();

}  // namespace hapton
