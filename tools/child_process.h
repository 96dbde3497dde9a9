#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// How to start a program. Arguments are passed literally: there is no shell.
struct ChildCommand {
  std::filesystem::path program;  // a path with a slash, or a name looked for in PATH
  std::vector<std::string> arguments;
  std::filesystem::path folder;  // its working directory; empty: that of this process
  std::filesystem::path output;  // file for its stdout and stderr; empty: those of this process
};

// A child process, which ends with this object at the latest: the destructor stops it. A moved-from object may only be destroyed.
// RT: set-up only. Threads: one.
class ChildProcess {
 public:
  // Error: one line that names the program: not found, not executable.
  static Result<ChildProcess> start(const ChildCommand& command);

  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  // Process id, for /proc; -1 once it has ended.
  pid_t pid() const { return pid_; }

  // Waits until the child ends, at most so long. Returns its exit code (128 + n if signal n ended it); none: it still runs.
  std::optional<int> wait(double seconds);

  // Sends SIGTERM and waits; SIGKILL after the given time. Returns the exit code, as wait() does.
  int stop(double seconds = 5.0);

  // Sends SIGKILL, which ends the child at once, as a crash would, and waits for its end.
  void kill();

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}

  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

// The folder of the running executable, which also contains the other programs of Hapton.
std::filesystem::path find_own_folder();

}  // namespace hapton
