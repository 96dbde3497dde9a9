#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/base/result.h"

namespace hapton {

// The servo rate that was requested and the delay of the forces that was measured on a running system.
struct MeasuredLatency {
  double rate_hz = 0.0;
  double delay_s = 0.0;  // p99.9 of the round trip: from a sample until its force is ready for the device
};

// Reads them from a report.json of hapton latency or io_node. Error, one line: the report has no round trip or no servo rate. RT: no.
Result<MeasuredLatency> read_measured_latency(const nlohmann::ordered_json& report);

}  // namespace hapton
