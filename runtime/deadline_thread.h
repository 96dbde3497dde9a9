#pragma once

#include <cstdint>

namespace hapton {

// Schedules the calling thread as SCHED_DEADLINE: within each period it gets its runtime, before every SCHED_FIFO thread of any priority,
// and the kernel's throttling of real time does not stop it (docs/realtime.md). For a thread that must check in time even if others run
// wild, and needs little time. The deadline is the period's end: with an earlier one the kernel would make a thread that wakes again within
// its period wait for the next. False: not permitted (CAP_SYS_NICE, or a CPU affinity), and nothing changes. Units: ns; runtime <= period.
// RT: set-up only. Threads: acts on the caller.
bool enter_deadline(std::int64_t runtime_ns, std::int64_t period_ns) noexcept;

}  // namespace hapton
