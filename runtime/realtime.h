#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

enum class RealtimeMode : std::uint8_t {
  off,      // request only fine timers
  attempt,  // use what the system grants and report what it denied
  require,  // anything denied is an error
};

// "off", "try" or "require", as on the command line.
Result<RealtimeMode> parse_realtime_mode(std::string_view text);

constexpr int kMaxRealtimePriority = 99;  // the highest of SCHED_FIFO in Linux

struct RealtimeSettings {
  RealtimeMode mode = RealtimeMode::attempt;
  int priority = 80;            // SCHED_FIFO, 1 .. 99; 0: stay an ordinary thread
  int cpu = -1;                 // pin the thread to this CPU; -1: leave it to the scheduler
  bool lock_memory = true;      // mlockall: pages stay in memory, so that the loop has no page faults
  bool low_dma_latency = true;  // keep CPUs out of deep sleep: /dev/cpu_dma_latency, held open by the process until it ends
};

// One request to the system.
struct RealtimeItem {
  std::string name;       // "priority", "CPU", "memory lock", "timer slack", "wake-up latency"
  std::string requested;  // "SCHED_FIFO 80"
  bool obtained = false;
  std::string reason;  // why it was denied, in the system's words; empty if obtained
  std::string remedy;  // how to obtain it, one line
};

struct RealtimeReport {
  std::vector<RealtimeItem> items;
  // The share of a CPU's time that the kernel gives real-time threads before it throttles them; empty if no priority was obtained, or the
  // share is unknown.
  std::optional<double> allowed_share;

  bool complete() const;  // every item was obtained
  // "real time: priority SCHED_FIFO 80: granted; CPU 1: granted; memory lock all: denied (reason; remedy) …" in one line.
  std::string to_text() const;
  // The same text for a log: granted and denied items in the first line, then a line for each rejection with its remedy.
  std::vector<std::string> to_lines() const;
};

// Makes the calling thread as close to real time as the system permits: timer slack 1 ns in every mode, the rest as requested. Call it from
// the real-time thread, after its memory has been allocated. The report has the result of each request. Error, one line with the remedy:
// something was denied in mode `require`, or the priority is out of range. RT: set-up only. Threads: acts on the caller; the memory lock
// and the wake-up latency act on the process.
Result<RealtimeReport> enter_realtime(const RealtimeSettings& settings);

// The CPU for programs that reply to each other in turn: if all are pinned to it, a datagram wakes no other CPU. It is the last one that
// this process may use; -1 if there is only one. RT: set-up only.
int find_shared_cpu();

}  // namespace hapton
