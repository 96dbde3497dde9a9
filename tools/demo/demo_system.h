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
    std::filesystem::path out;        // report.json and logs/; exists
    std::filesystem::path scratch;    // for temporary files; exists
    int cpu = -1;                     // for hub and haptics node
    bool records = false;             // the session, into scratch
    std::vector<std::string> vision;  // more for its command line: --offscreen, --screenshot FILE
  };

  explicit DemoSystem(Settings settings) : settings_(std::move(settings)) {}

  // All but the vision node; the hub last, when the haptics node is ready.
  Result<void> start(const DemoStep& step);
  Result<void> start_vision(const DemoStep& step);

  // As a crash would.
  void kill_haptics();
  Result<void> start_haptics();

  // Error: one of them has ended, however it did.
  Result<void> check_running();
  // False: closed by the person before it.
  bool is_vision_open();

  // Stops the nodes in order: the picture while there is a probe to show, the hub last. Post: report.json exists, and the recording if one
  // was requested.
  Result<void> stop();

  std::filesystem::path report() const { return settings_.out / "report.json"; }
  std::filesystem::path recording() const { return settings_.scratch / "session.hapton"; }

 private:
  Result<void> prepare(const DemoStep& step);
  Result<void> start_hub();
  Result<void> start_relay(const DemoStep& step);

  Settings settings_;
  std::filesystem::path scene_;
  std::string hub_;        // where the hub listens
  std::string nodes_hub_;  // where the haptics node looks for it
  std::optional<LocalNode> io_;
  std::optional<LocalNode> relay_;
  std::optional<LocalNode> haptics_;
  std::optional<LocalNode> vision_;
};

}  // namespace hapton
