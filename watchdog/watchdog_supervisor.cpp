#include "watchdog/watchdog_supervisor.h"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <string>

#include "runtime/clock.h"

namespace hapton {

std::filesystem::path WatchdogSupervisor::find_program() {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? std::filesystem::path() : self.parent_path() / "hapton_watchdog";
}

Result<void> WatchdogSupervisor::start(const HeartbeatMemory& memory, const std::filesystem::path& program, int priority) {
  memory_ = &memory;
  program_ = program;
  priority_ = priority;
  return spawn();
}

Result<void> WatchdogSupervisor::spawn() {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawnattr_init(&attributes);
  // Besides the standard streams the child gets only the shared memory: a socket that it kept would hold our port after our end.
  ::posix_spawn_file_actions_adddup2(&actions, memory_->file(), kHeartbeatFile);
  ::posix_spawn_file_actions_addclosefrom_np(&actions, kHeartbeatFile + 1);
  // The child gets its own process group: Ctrl-Z and Ctrl-C at the terminal then reach only this process.
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string program = program_.string();
  std::string process = std::to_string(::getpid());
  std::string priority = std::to_string(priority_);
  const std::array<char*, 4> words = {program.data(), process.data(), priority.data(), nullptr};
  pid_t child = 0;
  const int error = ::posix_spawn(&child, program.c_str(), &actions, &attributes, words.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    return fail("the watchdog {} cannot be started: {}; install it beside io_node, or start with --watchdog off", program,
                std::strerror(error));
  }
  process_ = child;
  started_ns_ = SteadyClock().now_ns();
  return {};
}

// Kills a watchdog that hangs. If it is in an uninterruptible sleep, it ends only after that, and this process must not wait for it. False:
// it has not ended, nor has another one that was killed earlier.
bool WatchdogSupervisor::end() {
  ::kill(process_, SIGKILL);
  SteadyClock clock;
  const std::int64_t until_ns = clock.now_ns() + kEndNs;
  bool has_ended = ::waitpid(process_, nullptr, WNOHANG) != 0;
  for (; !has_ended && clock.now_ns() < until_ns; has_ended = ::waitpid(process_, nullptr, WNOHANG) != 0)
    clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
  if (has_ended) return true;
  if (killed_process_ != 0) return false;
  killed_process_ = process_;
  return true;
}

std::optional<Result<void>> WatchdogSupervisor::restart_if_dead(std::int64_t now_ns) {
  if (killed_process_ != 0 && ::waitpid(killed_process_, nullptr, WNOHANG) != 0) killed_process_ = 0;
  if (started_ns_ == 0 || now_ns - started_ns_ < kPeerTimeoutNs) return std::nullopt;
  if (process_ > 0) {
    const bool has_ended = ::waitpid(process_, nullptr, WNOHANG) != 0;
    const bool has_timed_out = now_ns - memory_->page().watchdog_beat_ns.load() > kPeerTimeoutNs;
    if (!has_ended && !has_timed_out) return std::nullopt;
    if (!has_ended && !end()) {
      started_ns_ = now_ns;  // tries again after kPeerTimeoutNs
      return Result<void>(
          fail("the kernel does not let the watchdog process {} end; the device may not answer: check its cable", process_));
    }
    // The kernel may soon give its id to another process.
    process_ = 0;
  }
  const Result<void> restarted = spawn();
  restarts_ += restarted ? 1 : 0;
  if (!restarted) started_ns_ = now_ns;  // tries again after kPeerTimeoutNs
  return restarted;
}

}  // namespace hapton
