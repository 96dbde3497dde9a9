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
  std::filesystem::path folder;  // it runs there; empty: here
  std::filesystem::path output;  // its stdout and stderr go to this file; empty: to ours
};

// A program that runs beside ours and ends with this object at the latest. RT: set-up only. Threads:
// one.
class ChildProcess {
 public:
  // Error: one line that names the program: not found, not executable.
  static Result<ChildProcess> start(const ChildCommand& command);

  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  // Whom to look for in /proc; -1 once it has ended.
  pid_t pid() const { return pid_; }

  // Its exit code (128 + n when signal n ended it), or none when it still runs after that time.
  std::optional<int> wait(double seconds);

  // Requests its end and waits; kills it after the given time.
  int stop(double seconds = 5.0);

  // Ends it at once, as a crash would.
  void kill();

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}

  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

// The folder of the running program, where its neighbours live.
std::filesystem::path find_own_folder();

}  // namespace hapton
