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
  std::filesystem::path out;           // of a run by script: pictures, and a folder for each step with its report and logs; exists
  std::optional<double> seconds = {};  // for each step
  int cpu = -1;                        // for hub and haptics node
};

// What a step by script came to.
struct DemoOutcome {
  DemoVerdict verdict;
  std::filesystem::path picture;
};

// How long a step by script takes by default, s, and at least: the hand is on its way for one and a half.
inline constexpr double kDemoSeconds = 6.0;
inline constexpr double kLeastDemoSeconds = 4.0;

// One step by script: for so many seconds, and some more where its picture is not taken yet. Pre: there is a display (local_node.h).
// Error: one line: a node that did not start or did not end well, a stop that was asked for. RT: set-up only.
Result<DemoOutcome> run_demo_step(std::size_t number, const DemoSettings& settings, const StopSignal& stop);

enum class DemoChoice { next, go_to, quit };
struct DemoRequest {
  DemoChoice choice = DemoChoice::quit;
  std::size_t number = 0;  // of go_to
};

// What a key asks for; none: it is none of the tour's.
std::optional<DemoRequest> find_demo_request(char key);

// One step in a window, until a key, the closing of the window or the end of its seconds says how to go on. Error: as above.
Result<DemoRequest> watch_demo_step(std::size_t number, const DemoSettings& settings, const StopSignal& stop, KeyReader& keys);

}  // namespace hapton
