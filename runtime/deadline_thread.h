#pragma once

#include <cstdint>

namespace hapton {

// Puts the calling thread under SCHED_DEADLINE: within each period it gets its runtime, before every SCHED_FIFO thread of any priority, and
// the kernel's throttling of real-time threads does not stop it (docs/realtime.md). For a thread that needs little time, but must run in
// time even if other threads never yield. The deadline is the period's end: with an earlier one the kernel would make a thread that wakes
// again within its period wait for the next period. False: not permitted (CAP_SYS_NICE, or a CPU affinity), and nothing changes. Units: ns.
// Pre: runtime <= period. RT: set-up only. Threads: acts on the caller.
bool enter_deadline(std::int64_t runtime_ns, std::int64_t period_ns) noexcept;

}  // namespace hapton
