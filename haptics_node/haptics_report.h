#pragma once

#include <string>

#include "core/tool/held_tool.h"
#include "haptic_step/haptics_step.h"
#include "haptics_node/state_wait.h"
#include "link/hub_client.h"
#include "runtime/latency_histogram.h"

namespace hapton {

// A few lines for people about a run: replies, contact, skipped and lost samples, the times of the step and from arrival to reply, and the
// method's own report, or with a rigid tool its largest torque and its pairs of triangles in contact. RT: set-up only.
std::string make_haptics_report(const HapticsStep& step, const HubClient& hub, const LatencyHistogram& compute_times,
                                const LatencyHistogram& step_times);

// The line "WHAT: p50 .. us, p90 .., p99 .., p99.9 .., worst .., n ..\n"; empty if no time was recorded. RT: set-up only.
std::string describe_times(const std::string& what, const LatencyHistogram& times);

// A text without a line end: how often the pose of a tool came so late that its force faded, and what helps. Empty: never. RT: set-up only.
std::string describe_late_tool(const HeldTool::Lateness& lateness);

// A line: how often the loop spun for a sample, and how often a sample arrived meanwhile. Empty if it never spun. RT: set-up only.
std::string describe_spins(const StateWait& wait);

// Logs the method's report, line by line. Lines that begin with "note: " (what the method leaves out of the scene) are logged as warnings.
// Of the lines that begin with "object ", only the first is logged, with the number of the others. RT: no.
void log_method(const ForceMethod& method);

}  // namespace hapton
