#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/demo/demo_step.h"
#include "tools/local_node.h"

namespace hapton {

// The nodes of one step of the tour, over loopback as deploy/run starts them: the hub with the simulated hand on its path, the relay if the
// step has one, the haptics node and the vision node. They end with this object at the latest. RT: set-up only. Error: one line that names
// the program, with its last output. Threads: one.
class DemoSystem {
 public:
  struct Settings {
    std::filesystem::path out;        // folder for report.json and NAME.log of each node; exists
    std::filesystem::path scratch;    // folder for temporary files; exists
    int cpu = -1;                     // the CPU of hub and haptics node; -1: any
    bool records = false;             // records the session into scratch
    std::vector<std::string> vision;  // further flags of the vision node: --offscreen, --screenshot FILE
  };

  explicit DemoSystem(Settings settings) : settings_(std::move(settings)) {}

  // Starts all nodes but the vision node; the hub last, when the haptics node is ready.
  Result<void> start(const DemoStep& step);
  Result<void> start_vision(const DemoStep& step);

  // Ends the haptics node at once, as a crash would. Pre: it was started.
  void kill_haptics();
  Result<void> start_haptics();

  // Error: one of the started nodes has ended, with an error or without.
  Result<void> check_running();
  // False: the vision node was not started or has ended, as when a person closes its window.
  bool is_vision_open();

  // Stops the vision node, the haptics node, the hub and the relay, in this order. Error: one of them did not end well; without an error
  // report.json exists, and the recording if one was requested.
  Result<void> stop();

  std::filesystem::path report() const { return settings_.out / "report.json"; }
  std::filesystem::path recording() const { return settings_.scratch / "session.hapton"; }

 private:
  Result<void> prepare(const DemoStep& step);
  Result<void> start_hub();
  Result<void> start_relay(const DemoStep& step);

  Settings settings_;
  std::filesystem::path scene_;
  std::string hub_;        // address at which the hub listens
  std::string nodes_hub_;  // address to which the haptics node connects: that of the hub or of the relay
  std::optional<LocalNode> io_;
  std::optional<LocalNode> relay_;
  std::optional<LocalNode> haptics_;
  std::optional<LocalNode> vision_;
};

}  // namespace hapton
