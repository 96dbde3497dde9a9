#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// Whether a servo rate could be held by what was measured.
struct RateVerdict {
  double rate_hz = 0.0;
  bool fits = false;
  double margin_us = 0.0;  // what is left of a period; below zero: what it lacks
};

// What a run says about the rates that Hapton is used at.
struct LatencyVerdict {
  double rate_hz = 0.0;  // measured at
  double need_us = 0.0;  // p99.9 of the wake-up and p99.9 of the round trip together
  double missed_share = 0.0;
  std::vector<RateVerdict> rates;  // 1, 4 and 10 kHz
  bool holds = false;              // the rate it was measured at
  std::string reason;              // why it does not; empty when it does
};

// The rule. A rate fits when the servo's wake-up and the force's round trip, both at p99.9, lie within one period: then the force for a
// sample is on the device before the next sample is taken, all but twice in a thousand times. The rate measured at must besides have missed
// no more than kMaxMissedShare of its cycles: late, lost or superseded answers, and ticks that went by.
constexpr double kMaxMissedShare = 1e-3;

// From a report.json. Error: it is none, or nothing was answered.
Result<LatencyVerdict> judge_latency(const nlohmann::json& report);

nlohmann::ordered_json to_json(const LatencyVerdict& verdict);
// A line or two for people.
std::string to_text(const LatencyVerdict& verdict);

}  // namespace hapton
