#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/child_process.h"

namespace hapton {

// A whole file as text; empty when it cannot be read.
std::string read_text(const std::filesystem::path& path);

// An address of 127.0.0.1 with a UDP port that is free at the moment.
Result<std::string> find_free_address();

// A program of a measurement, writing to FOLDER/NAME.log. It ends with this object at the latest. RT: set-up only. Error: one line that
// names the program, with its last output. Threads: one.
class LocalNode {
 public:
  static Result<LocalNode> start(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& program,
                                 std::vector<std::string> arguments);

  // Waits until the text appears in its log.
  Result<void> wait_for(const std::string& text);

  // Until its log has a line that is a whole number and nothing else; gives that line.
  Result<std::string> wait_for_number();

  // To its end, which is due after that time.
  Result<void> wait_for_end(double seconds);

  // Error: it has ended, however it did.
  Result<void> check_running();

  Result<void> stop();

  // Ends it at once, as a crash would.
  void kill() { process_.kill(); }

  const std::string& name() const { return name_; }
  pid_t pid() const { return process_.pid(); }
  std::string last_line() const;

 private:
  LocalNode(std::string name, std::filesystem::path log, ChildProcess process);

  template <class Holds>
  Result<void> wait_until(Holds&& holds_of_log);
  Result<void> failed(int code) const;

  std::string name_;
  std::filesystem::path log_;
  ChildProcess process_;
};

// `hapton relay` of this build in front of a hub, and where nodes find the hub through it.
struct LocalRelay {
  LocalNode node;
  std::string address;
};
// faults: more words of its command line. RT: set-up only. Error: as LocalNode.
Result<LocalRelay> start_local_relay(const std::filesystem::path& folder, const std::string& hub, const std::vector<std::string>& faults);

// A virtual display, for what draws unseen where there is no other. While it lives, DISPLAY names it.
// RT: set-up only. Error: as LocalNode. Threads: one.
class LocalDisplay {
 public:
  LocalDisplay() = default;
  ~LocalDisplay();
  LocalDisplay(const LocalDisplay&) = delete;
  LocalDisplay& operator=(const LocalDisplay&) = delete;

  // Nothing is started where there is a display.
  Result<void> start_if_none(const std::filesystem::path& folder);

 private:
  std::optional<LocalNode> server_;
};

// A vision node that draws unseen, and the virtual display that it draws on where there is no other.
// RT: set-up only. Error: as LocalNode. Threads: one.
class LocalVision {
 public:
  Result<void> start(const std::filesystem::path& folder, std::vector<std::string> arguments);
  Result<void> stop();

  // Pre: started.
  LocalNode& node() { return *node_; }

 private:
  LocalDisplay display_;
  std::optional<LocalNode> node_;
};

}  // namespace hapton
