#include "tools/loop/measured_latency.h"

#include <nlohmann/json.hpp>

namespace hapton {

Result<MeasuredLatency> read_measured_latency(const nlohmann::ordered_json& report) {
  const auto member = [](const nlohmann::ordered_json& object, const char* name) {
    const auto found = object.is_object() ? object.find(name) : object.end();
    return found == object.end() ? nlohmann::ordered_json() : *found;
  };
  const nlohmann::ordered_json delay_us = member(member(member(report, "hops"), "round_trip"), "p99_9_us");
  const nlohmann::ordered_json rate_hz = member(member(report, "rates_hz"), "servo_requested");
  if (!delay_us.is_number()) return fail("no force round trip was measured");
  if (!rate_hz.is_number() || !(rate_hz.get<double>() > 0.0)) return fail("has no servo rate");
  return MeasuredLatency{rate_hz.get<double>(), 1e-6 * delay_us.get<double>()};
}

}  // namespace hapton
