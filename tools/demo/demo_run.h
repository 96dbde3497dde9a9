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
  std::filesystem::path out;           // scripted steps: folder for pictures, and for a folder of each step with report and logs
  std::optional<double> seconds = {};  // duration of each step; none: scripted kDemoSeconds, in a window until a key
  int cpu = -1;                        // the CPU of hub and haptics node; -1: any
};

// The result of a scripted step.
struct DemoOutcome {
  DemoVerdict verdict;
  std::filesystem::path picture;
};

// Default and minimum duration of a scripted step, s; the approach of the hand takes 1.5 s of it.
inline constexpr double kDemoSeconds = 6.0;
inline constexpr double kMinDemoSeconds = 4.0;

// Runs one scripted step for its seconds, and longer (up to five times that) while its picture is not taken. Pre: a display (local_node.h).
// Error, one line: a node failed, there is no picture, a file cannot be read or written, or a stop was requested. RT: set-up only.
Result<DemoOutcome> run_demo_step(std::size_t number, const DemoSettings& settings, const StopSignal& stop);

enum class DemoChoice { next, go_to, quit };
struct DemoRequest {
  DemoChoice choice = DemoChoice::quit;
  std::size_t number = 0;  // the step to go to, for go_to
};

// The request that this key makes; none: the key has no function in the tour.
std::optional<DemoRequest> find_demo_request(char key);

// Shows one step in a window until a key, a stop, or the end of the window or its seconds. Error: a node did not start or end well.
Result<DemoRequest> watch_demo_step(std::size_t number, const DemoSettings& settings, const StopSignal& stop, KeyReader& keys);

}  // namespace hapton
