#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

enum class RealtimeMode : std::uint8_t {
  off,      // ask for nothing but fine timers
  attempt,  // take what the system grants and say what it refused
  require,  // anything refused is an error
};

// "off", "try" or "require", as on the command line.
Result<RealtimeMode> parse_realtime_mode(std::string_view text);

struct RealtimeSettings {
  RealtimeMode mode = RealtimeMode::attempt;
  int priority = 80;            // SCHED_FIFO, 1 .. 99; 0: stay an ordinary thread
  int cpu = -1;                 // pin the thread to this CPU; -1: leave it to the scheduler
  bool lock_memory = true;      // no page faults later: mlockall
  bool low_dma_latency = true;  // keep CPUs out of deep sleep: /dev/cpu_dma_latency, held open by the process until it ends
};

// One thing asked of the system.
struct RealtimeItem {
  std::string name;   // "priority", "cpu", "memory lock", "timer slack", "wake-up latency"
  std::string asked;  // "SCHED_FIFO 80"
  bool obtained = false;
  std::string reason;  // of a rejection, the system's words
  std::string remedy;  // what a person can do about it, one line
};

struct RealtimeReport {
  std::vector<RealtimeItem> items;
  // Of a CPU's time, what the kernel lets real-time threads have before it throttles them; none without a priority, or when it does not
  // say.
  std::optional<double> allowed_share;

  bool complete() const;
  // "real time: priority SCHED_FIFO 80 yes; cpu 1 yes; memory lock NO (…: remedy) …" in one line.
  std::string to_text() const;
  // The same for a log: what was granted and what not in the first line, then a line for each rejection with its remedy.
  std::vector<std::string> to_lines() const;
};

// Makes the calling thread as punctual as the system lets it: timer slack 1 ns always, the rest as asked. Call it from the thread that
// keeps time, after its memory has been allocated. No return code is ignored.
// Error: mode require and something refused, or settings that make no sense: one line with the remedy.
// RT: set-up only. Threads: acts on the caller; the memory lock and the wake-up latency on the process.
Result<RealtimeReport> enter_realtime(const RealtimeSettings& settings);

// The CPU for programs that answer each other in turn, so that a datagram wakes nobody on another one: the last that this process may
// use; -1 if there is but one.
int find_shared_cpu();

}  // namespace hapton
