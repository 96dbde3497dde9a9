#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace hapton::attack {

// Stops one thread of another process, as if it hung, until this object ends. The other threads are not affected.
class StoppedThread {
 public:
  explicit StoppedThread(pid_t thread);
  ~StoppedThread();
  StoppedThread(const StoppedThread&) = delete;
  StoppedThread& operator=(const StoppedThread&) = delete;
  // False: this user may not stop the thread (ptrace(2)).
  bool is_stopped() const { return is_stopped_; }

 private:
  pid_t thread_;
  bool is_stopped_ = false;
};

// The thread of the process that has this name; empty if there is none.
std::optional<pid_t> find_thread(pid_t process, const std::string& name);
// The child processes of the process.
std::vector<pid_t> find_children(pid_t process);

// A real-time program that uses every CPU fully: on each CPU a process that never sleeps, of lower priority than Hapton's real-time
// threads.
class RealtimeHog {
 public:
  static constexpr int kPriority = 50;
  RealtimeHog();
  ~RealtimeHog();
  RealtimeHog(const RealtimeHog&) = delete;
  RealtimeHog& operator=(const RealtimeHog&) = delete;
  // False: this user may not have real-time scheduling.
  bool is_running() const { return !children_.empty(); }

 private:
  std::vector<pid_t> children_;
};

}  // namespace hapton::attack
