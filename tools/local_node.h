#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/child_process.h"

namespace hapton {

// Returns a whole file as text; empty if it cannot be read.
std::string read_text(const std::filesystem::path& path);

// Returns an address of 127.0.0.1 with a UDP port that is free at the moment.
Result<std::string> find_free_address();

// A child process of a measurement; its output goes to FOLDER/NAME.log. It ends with this object at the latest. RT: set-up only. Error: one
// line that names the program, with the last line of its output or the path of its log. Threads: one.
class LocalNode {
 public:
  static Result<LocalNode> start(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& program,
                                 std::vector<std::string> arguments);

  // Waits until the text appears in its log, at most 120 s. Error also: the process ended before.
  Result<void> wait_for(const std::string& text);

  // Waits in the same way until its log has a line that is a whole number and nothing else; returns that line.
  Result<std::string> wait_for_number();

  // Waits until it ends. Error: it still runs after that time, or it ended with an exit code other than 0.
  Result<void> wait_for_end(double seconds);

  // Error: it has ended, with any exit code.
  Result<void> check_running();

  Result<void> stop();

  // Kills it at once, which has the effect of a crash.
  void kill() { process_.kill(); }

  const std::string& name() const { return name_; }
  pid_t pid() const { return process_.pid(); }
  std::string last_line() const;

 private:
  LocalNode(std::string name, std::filesystem::path log, ChildProcess process);

  template <class Condition>
  Result<void> wait_until(Condition&& is_met_by_log);
  Result<void> exit_error(int code) const;

  std::string name_;
  std::filesystem::path log_;
  ChildProcess process_;
};

// `hapton relay` of this build between nodes and a hub, and the address at which nodes reach the hub through it.
struct LocalRelay {
  LocalNode node;
  std::string address;
};
// faults: further arguments of `hapton relay`. RT: set-up only. Error: as for LocalNode.
Result<LocalRelay> start_local_relay(const std::filesystem::path& folder, const std::string& hub, const std::vector<std::string>& faults);

// A virtual display, for programs that draw offscreen when there is no display. While it runs, the environment's DISPLAY names it.
// RT: set-up only. Error: as for LocalNode. Threads: one; no other thread may use the environment meanwhile.
class LocalDisplay {
 public:
  LocalDisplay() = default;
  ~LocalDisplay();
  LocalDisplay(const LocalDisplay&) = delete;
  LocalDisplay& operator=(const LocalDisplay&) = delete;

  // Starts nothing if DISPLAY is set.
  Result<void> start_if_none(const std::filesystem::path& folder);

 private:
  std::optional<LocalNode> server_;
};

// A vision node that draws offscreen, with a virtual display of its own if there is no other display.
// RT: set-up only. Error: as for LocalNode. Threads: as for LocalDisplay.
class LocalVision {
 public:
  Result<void> start(const std::filesystem::path& folder, std::vector<std::string> arguments);
  Result<void> stop();

  // Pre: start() succeeded.
  LocalNode& node() { return *node_; }

 private:
  LocalDisplay display_;
  std::optional<LocalNode> node_;
};

}  // namespace hapton
