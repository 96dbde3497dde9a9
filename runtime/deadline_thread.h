#pragma once

#include <cstdint>

namespace hapton {

// Makes the calling thread one of SCHED_DEADLINE: within each period it gets its runtime, before every SCHED_FIFO thread of
// whatever priority, and the kernel's throttling of real time does not stop it (docs/realtime.md). For a thread that must look in time
// although others have run wild, and needs little. The deadline is the period's end: with an earlier one the kernel would keep a thread
// that wakes again within its period waiting for the next. False: refused (CAP_SYS_NICE, or a CPU affinity), and it stays what it was.
// Units: ns; runtime <= period. RT: set-up only. Threads: acts on the caller.
bool enter_deadline(std::int64_t runtime_ns, std::int64_t period_ns) noexcept;

}  // namespace hapton
