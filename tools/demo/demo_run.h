#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "runtime/stop_signal.h"
#include "tools/demo/demo_step.h"
#include "tools/demo/key_reader.h"

namespace hapton {

struct DemoSettings {
  std::filesystem::path out;           // of a scripted run: pictures, and a folder for each step with its report and logs; exists
  std::optional<double> seconds = {};  // for each step
  int cpu = -1;                        // for hub and haptics node
};

// The result of a scripted step.
struct DemoOutcome {
  DemoVerdict verdict;
  std::filesystem::path picture;
};

// Default and minimum duration of a scripted step, s: the hand's approach takes one and a half.
inline constexpr double kDemoSeconds = 6.0;
inline constexpr double kMinDemoSeconds = 4.0;

// Runs one scripted step: for its seconds, and longer if its picture has not been taken yet. Pre: there is a display (local_node.h). Error:
// one line: a node that did not start or did not end well, a requested stop. RT: set-up only.
Result<DemoOutcome> run_demo_step(std::size_t number, const DemoSettings& settings, const StopSignal& stop);

enum class DemoChoice { next, go_to, quit };
struct DemoRequest {
  DemoChoice choice = DemoChoice::quit;
  std::size_t number = 0;  // of go_to
};

// The request of a key; empty: the key has no function in the tour.
std::optional<DemoRequest> find_demo_request(char key);

// Shows one step in a window, until a key, the closing of the window or the end of its seconds. Error: as above.
Result<DemoRequest> watch_demo_step(std::size_t number, const DemoSettings& settings, const StopSignal& stop, KeyReader& keys);

}  // namespace hapton
