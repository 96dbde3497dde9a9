#pragma once

#include <string>

#include "io_node/io_options.h"
#include "io_node/scheduling_monitor.h"
#include "io_node/servo_stats.h"
#include "link/messages.h"
#include "runtime/report.h"

namespace hapton {

// The report of a run, for report.json: hops (docs/latency.md), rates and counters of the stats, and notes on the machine and the options,
// so that the run can be repeated. Hops: round_trip, haptics_compute, wire, force_age, wake_lateness, device_read, device_to_drawn,
// bare_echo. Ratios: round_trip_over_echo_p50 and _p99, if an echo was measured. realtime: RealtimeReport::to_text(). RT: no.
LatencyReport make_io_report(const ServoStats& stats, const IoOptions& options, const std::string& realtime,
                             const SchedulingStats& scheduling = {});

// "io", "haptics", "vision" or "tool". RT: yes.
const char* name_of(NodeRole role);

// Describes the run to a person: a few lines, and a table of the latency of every hop that was measured. RT: no.
std::string describe_run(const ServoStats& stats, const SchedulingStats& scheduling = {});

}  // namespace hapton
