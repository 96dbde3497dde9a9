#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// Whether the measured run could hold a servo rate.
struct RateVerdict {
  double rate_hz = 0.0;
  bool fits = false;
  double margin_us = 0.0;  // time left of a period; below zero: time missing
};

// Verdicts of a run on the usual rates.
struct LatencyVerdict {
  double rate_hz = 0.0;  // measured at
  double need_us = 0.0;  // p99.9 of the wake-up and p99.9 of the round trip together
  double missed_share = 0.0;
  std::vector<RateVerdict> rates;  // 1, 4 and 10 kHz
  bool holds = false;              // the rate it was measured at
  std::string reason;              // why it does not; empty when it does
};

// The rule. A rate fits if the servo's wake-up and the force's round trip, both at p99.9, lie within one period: then the force for a
// sample is on the device before the next sample is taken, in all but two of a thousand cycles. The measured rate must in addition have
// missed at most kMaxMissedShare of its cycles: late, lost or superseded replies, and missed ticks.
constexpr double kMaxMissedShare = 1e-3;

// From a report.json. Error: it is not one, or it has no replies.
Result<LatencyVerdict> evaluate_latency(const nlohmann::json& report);

nlohmann::ordered_json to_json(const LatencyVerdict& verdict);
// A line or two for people.
std::string to_text(const LatencyVerdict& verdict);

}  // namespace hapton
