#pragma once

#include <string>

#include "core/tool/held_tool.h"
#include "haptic_step/haptics_step.h"
#include "haptics_node/state_wait.h"
#include "link/hub_client.h"
#include "runtime/latency_histogram.h"

namespace hapton {

// A few lines for people about a run: replies, contact, skipped and lost samples, times of the step and from arrival to reply, and the
// method's own report. RT: set-up only.
std::string make_haptics_report(const HapticsStep& step, const HubClient& hub, const LatencyHistogram& compute_times,
                                const LatencyHistogram& step_times);

// "WHAT: p50 .. us, p90 .., p99 .., p99.9 .., worst .., n ..", a line; empty if there are none. RT: set-up only.
std::string describe_times(const std::string& what, const LatencyHistogram& times);

// That the pose of a tool came so late that its force faded, how often and what helps, a line; empty if it never did. RT: set-up only.
std::string describe_late_tool(const HeldTool::Lateness& lateness);

// How often the loop spun for a sample and how often one arrived meanwhile, a line; empty if it never spun. RT: set-up only.
std::string describe_spins(const StateWait& wait);

// Logs the method's report, line by line; what it leaves out of the scene ("note: ...") as warnings. Of the lines on objects only the
// first, with their count. RT: no.
void log_method(const ForceMethod& method);

}  // namespace hapton
