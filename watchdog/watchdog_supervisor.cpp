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
  // Besides the standard streams the child gets only the shared memory. If it had io_node's sockets, their ports would stay in use after
  // io_node has ended.
  ::posix_spawn_file_actions_adddup2(&actions, memory_->file(), kHeartbeatDescriptor);
  ::posix_spawn_file_actions_addclosefrom_np(&actions, kHeartbeatDescriptor + 1);
  // The child gets its own process group: Ctrl-Z and Ctrl-C at the terminal then reach only this process.
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string program = program_.string();
  std::string own_process = std::to_string(::getpid());
  std::string priority = std::to_string(priority_);
  const std::array<char*, 4> arguments = {program.data(), own_process.data(), priority.data(), nullptr};
  pid_t child = 0;
  const int error = ::posix_spawn(&child, program.c_str(), &actions, &attributes, arguments.data(), environ);
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

// Kills the watchdog, which hangs, and waits until it has ended, but for kMaxKillWaitNs at most: a process in an uninterruptible sleep ends
// only after that sleep. One such process may remain while another watchdog is started. False: an earlier one remains already.
bool WatchdogSupervisor::kill_hung() {
  ::kill(process_, SIGKILL);
  SteadyClock clock;
  const std::int64_t until_ns = clock.now_ns() + kMaxKillWaitNs;
  bool has_ended = ::waitpid(process_, nullptr, WNOHANG) != 0;
  for (; !has_ended && clock.now_ns() < until_ns; has_ended = ::waitpid(process_, nullptr, WNOHANG) != 0)
    clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
  if (has_ended) return true;
  if (unended_process_ != 0) return false;
  unended_process_ = process_;
  return true;
}

std::optional<Result<void>> WatchdogSupervisor::restart_if_dead(std::int64_t now_ns) {
  if (unended_process_ != 0 && ::waitpid(unended_process_, nullptr, WNOHANG) != 0) unended_process_ = 0;
  if (started_ns_ == 0 || now_ns - started_ns_ < kWatchdogTimeoutNs) return std::nullopt;
  if (process_ > 0) {
    const bool has_ended = ::waitpid(process_, nullptr, WNOHANG) != 0;
    const bool has_timed_out = now_ns - memory_->page().watchdog_beat_ns.load() > kWatchdogTimeoutNs;
    if (!has_ended && !has_timed_out) return std::nullopt;
    if (!has_ended && !kill_hung()) {
      started_ns_ = now_ns;  // tries again after kWatchdogTimeoutNs
      return Result<void>(
          fail("the kernel does not let the watchdog process {} end; the device may not answer: check its cable", process_));
    }
    // It has ended or was killed. Its id may soon be that of another process, so nothing is sent to it any more.
    process_ = 0;
  }
  const Result<void> restarted = spawn();
  restarts_ += restarted ? 1 : 0;
  if (!restarted) started_ns_ = now_ns;  // tries again after kWatchdogTimeoutNs
  return restarted;
}

}  // namespace hapton
