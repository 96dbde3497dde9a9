#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <sys/types.h>

namespace hapton {

// What the system did with a thread since it began, as the system counts.
struct ThreadUsage {
  double run_s = 0.0;     // on a CPU
  double waited_s = 0.0;  // ready to run, but kept waiting for a CPU
  std::uint64_t voluntary_switches = 0;
  std::uint64_t involuntary_switches = 0;  // another thread took its CPU
  double stolen_s = 0.0;                   // of the whole machine: time that a hypervisor kept from it
};

// The calling thread's number, for read_thread_usage. RT: set-up only.
pid_t current_thread_id();

// Of a thread of this process, from /proc; none when it is gone or the system does not tell. RT: no.
std::optional<ThreadUsage> read_thread_usage(pid_t thread);

// How much of a CPU's time the kernel lets real-time threads have, 0 to 1 (sched_rt_runtime_us over sched_rt_period_us); 1: all of it, and
// none when it does not say. A thread above it stands still for the rest of each period. RT: no.
std::optional<double> read_realtime_share();

}  // namespace hapton
