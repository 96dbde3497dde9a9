#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/base/result.h"
#include "watchdog/heartbeat_memory.h"

namespace hapton {

// The watchdog as a child process of this one: started, monitored, restarted when it has died. It ends by itself when this process
// does. One that hangs is killed; where the kernel keeps it nevertheless (a write to a device that does not return), another takes its
// place, but no third one. RT: no. Threads: one.
class WatchdogSupervisor {
 public:
  static constexpr std::int64_t kPeerTimeoutNs = 1'000'000'000;  // without a heartbeat of the watchdog; then it is restarted
  // How long the end of one that was killed is waited for: a hundred times what it takes.
  static constexpr std::int64_t kEndNs = 100'000'000;

  // The program hapton_watchdog in the folder of this executable.
  static std::filesystem::path find_program();

  // Pre: memory outlives this. priority: SCHED_FIFO; 0: an ordinary process. Error, one line: the program is missing or cannot be started.
  Result<void> start(const HeartbeatMemory& memory, const std::filesystem::path& program, int priority);

  // Call it a few times a second. A value: the watchdog had died or hung, and was restarted, or could not be, which the next call a second
  // later tries again; the caller reports that.
  std::optional<Result<void>> restart_if_dead(std::int64_t now_ns);

  bool is_started() const noexcept { return memory_ != nullptr && process_ > 0; }
  // 0: there is none.
  pid_t id() const noexcept { return process_; }
  // How often it was restarted, and how often it has released the force.
  std::uint64_t restarts() const noexcept { return restarts_; }
  std::uint64_t cuts() const noexcept { return memory_ != nullptr ? memory_->page().cuts.load() : 0; }

 private:
  Result<void> spawn();
  bool end();

  const HeartbeatMemory* memory_ = nullptr;
  std::filesystem::path program_;
  int priority_ = 0;
  pid_t process_ = 0;
  pid_t killed_ = 0;  // one before, which has not ended yet; 0: none
  std::int64_t started_ns_ = 0;
  std::uint64_t restarts_ = 0;
};

}  // namespace hapton
