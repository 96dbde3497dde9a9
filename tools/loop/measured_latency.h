#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/base/result.h"

namespace hapton {

// How late forces are on a system that was measured.
struct MeasuredLatency {
  double rate_hz = 0.0;
  double delay_s = 0.0;  // from the sample to its force on the device, p99.9 of the round trip
};

// From a report.json of hapton latency or io_node. Error: it is none, or no force was measured.
Result<MeasuredLatency> read_measured_latency(const nlohmann::ordered_json& report);

}  // namespace hapton
