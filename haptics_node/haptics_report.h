#pragma once

#include <string>

#include "haptics_node/haptics_step.h"
#include "link/hub_client.h"
#include "runtime/latency_histogram.h"

namespace hapton {

// A few lines for people about a run: answers, contact, what was skipped or lost, compute times, and the method's own words.
// RT: set-up only.
std::string make_haptics_report(const HapticsStep& step, const HubClient& hub, const LatencyHistogram& compute_times);

// What the method says of itself, line by line to the log. RT: no.
void log_method(const ForceMethod& method);

}  // namespace hapton
