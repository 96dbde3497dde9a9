#pragma once

#include <string>

#include "runtime/report.h"

namespace hapton {

// The report in Prometheus' text format, version 0.0.4: counters as hapton_NAME_total (those named longest_... as gauges), rates and
// ratios as gauges, nodes as counters, each hop as a histogram hapton_latency_seconds{hop="..."} with bounds at 1, 2 and 5 of each decade.
// Times are in seconds, as the conventions of Prometheus demand. RT: no.
std::string to_prometheus(const LatencyReport& report);

}  // namespace hapton
