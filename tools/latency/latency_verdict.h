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
  double margin_us = 0.0;  // the part of a period that is left; below zero: by how much the period is too short
};

// The verdict of a run at its own servo rate, and at the usual rates.
struct LatencyVerdict {
  double rate_hz = 0.0;  // the servo rate of the run
  double need_us = 0.0;  // the sum of p99.9 of the wake-up and p99.9 of the round trip
  double missed_share = 0.0;
  std::vector<RateVerdict> rates;  // at 1, 4 and 10 kHz
  bool holds = false;              // the run could hold rate_hz
  std::string reason;              // why it could not; empty if it could
};

// The rule: a rate fits if the servo's wake-up and the force's round trip, both at p99.9, together take at most one period: then in all but
// two of a thousand cycles the force for a sample is on the device before the next sample is taken. For `holds`, in addition at most
// kMaxMissedShare of the cycles may have a late, lost or superseded reply or be missed.
constexpr double kMaxMissedShare = 1e-3;

// The verdict from a report.json. Error: it is not a report, or it has no forces or no servo rate.
Result<LatencyVerdict> evaluate_latency(const nlohmann::json& report);

nlohmann::ordered_json to_json(const LatencyVerdict& verdict);
// The verdict as two lines for people.
std::string to_text(const LatencyVerdict& verdict);

}  // namespace hapton
