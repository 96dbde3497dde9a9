#pragma once

#include <string>

#include "runtime/report.h"

namespace hapton {

// The report in Prometheus' text format, version 0.0.4: counters as hapton_NAME_total, rates, ratios and nodes as gauges or counters with
// labels, each hop as a summary hapton_latency_seconds{hop="..."}. Units are seconds, as its conventions want. RT: no.
std::string to_prometheus(const LatencyReport& report);

}  // namespace hapton
