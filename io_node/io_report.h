#pragma once

#include <string>

#include "io_node/io_options.h"
#include "io_node/scheduling_monitor.h"
#include "io_node/servo_stats.h"
#include "link/messages.h"
#include "runtime/report.h"

namespace hapton {

// The report of a run, for report.json: hops (docs/latency.md; bare_echo only with --echo-probe), rates, counters and ratios of
// the stats, and notes on the machine and the options, so that the run can be repeated. The ratios round_trip_over_echo_p50 and _p99 are
// there only if an echo was measured. realtime: the text of RealtimeReport::to_text(). RT: no.
LatencyReport make_io_report(const ServoStats& stats, const IoOptions& options, const std::string& realtime,
                             const SchedulingStats& scheduling = {});

// "io", "haptics", "vision" or "tool". RT: yes.
const char* name_of(NodeRole role);

// Describes the run to a person: a few lines, and a table of the latency of every hop that was measured. RT: no.
std::string describe_run(const ServoStats& stats, const SchedulingStats& scheduling = {});

}  // namespace hapton
