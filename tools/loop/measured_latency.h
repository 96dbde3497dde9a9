#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/base/result.h"

namespace hapton {

// Servo rate and delay of the forces, as measured on a running system.
struct MeasuredLatency {
  double rate_hz = 0.0;
  double delay_s = 0.0;  // from the sample to its force on the device, p99.9 of the round trip
};

// Reads them from a report.json of hapton latency or io_node. Error, one line: it is no such report, or it has no round trip. RT: no.
Result<MeasuredLatency> read_measured_latency(const nlohmann::ordered_json& report);

}  // namespace hapton
