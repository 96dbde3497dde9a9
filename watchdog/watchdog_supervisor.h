#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/base/result.h"
#include "watchdog/heartbeat_memory.h"

namespace hapton {

// Runs the watchdog as a child process: starts it, monitors it, and restarts it if it has died. The watchdog ends by itself when this
// process does. A watchdog that hangs is killed; if the kernel cannot end it yet (a write to a device does not return), a second one is
// started beside it, but not a third one. RT: no. Threads: one.
class WatchdogSupervisor {
 public:
  // A watchdog is restarted after this long without a heartbeat of it. A new one has the same time for its first heartbeat, and a restart
  // that failed is tried again after it.
  static constexpr std::int64_t kWatchdogTimeoutNs = 1'000'000'000;
  // The longest wait for the end of a watchdog that was killed: a hundred times what its end usually takes.
  static constexpr std::int64_t kMaxKillWaitNs = 100'000'000;

  // Path of the program hapton_watchdog in the folder of this executable.
  static std::filesystem::path find_program();

  // Pre: memory outlives this. priority: for SCHED_FIFO; 0: ordinary threads. Error, one line: the program is missing or cannot be started.
  Result<void> start(const HeartbeatMemory& memory, const std::filesystem::path& program, int priority);

  // Call it a few times a second. A value, for the caller to report: the watchdog had died or hung, and was restarted; an error: it could
  // not be restarted, and a call at least a second later tries again.
  std::optional<Result<void>> restart_if_dead(std::int64_t now_ns);

  bool is_started() const noexcept { return memory_ != nullptr && process_ > 0; }
  // The process id of the watchdog; 0: there is none.
  pid_t id() const noexcept { return process_; }
  // How often the watchdog was restarted, and how often it has released the force.
  std::uint64_t restarts() const noexcept { return restarts_; }
  std::uint64_t cuts() const noexcept { return memory_ != nullptr ? memory_->page().cuts.load() : 0; }

 private:
  Result<void> spawn();
  bool kill_hung();

  const HeartbeatMemory* memory_ = nullptr;
  std::filesystem::path program_;
  int priority_ = 0;
  pid_t process_ = 0;
  pid_t unended_process_ = 0;    // an earlier watchdog that was killed and has not ended yet; 0: none
  std::int64_t started_ns_ = 0;  // when process_ was started, or when a restart last failed; 0: never
  std::uint64_t restarts_ = 0;
};

}  // namespace hapton
