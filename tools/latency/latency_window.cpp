#include "tools/latency/latency_window.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "tools/json_number.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kMaximumPrefix = "longest_";  // prefix of a maximum, which is not a count: it holds for the whole run

Json subtract_counters(const Json& before, const Json& now) {
  Json counters = Json::object();
  for (const auto& [name, value] : now.items()) {
    if (!value.is_number_integer()) continue;
    const bool is_maximum = std::string_view(name).starts_with(kMaximumPrefix);
    counters[name] =
        is_maximum ? value.get<std::int64_t>() : value.get<std::int64_t>() - static_cast<std::int64_t>(json_number_of(before, name));
  }
  return counters;
}

Json hop_json(const HopCounts& hop) {
  const std::uint64_t total = hop.total();
  double sum_us = 0.0;
  for (const HopCounts::Bucket& bucket : hop.buckets) {
    sum_us += 0.5e-3 * static_cast<double>(bucket.lower_ns + bucket.upper_ns) * static_cast<double>(bucket.count);
  }
  return {{"n", total},
          {"p50_us", hop.quantile_us(0.5)},
          {"p90_us", hop.quantile_us(0.9)},
          {"p99_us", hop.quantile_us(0.99)},
          {"p99_9_us", hop.quantile_us(0.999)},
          {"max_us", hop.quantile_us(1.0)},
          {"mean_us", sum_us / static_cast<double>(total)}};
}

void add_ratio(Json& report, const char* name, const char* quantile) {
  const Json& hops = report["hops"];
  if (!hops.contains("round_trip") || !hops.contains("bare_echo")) return;
  const double echo_us = json_number_of(hops["bare_echo"], quantile);
  if (echo_us > 0.0) report["ratios"][name] = json_number_of(hops["round_trip"], quantile) / echo_us;
}

}  // namespace

Json make_window_report(const Json& before, const Json& now, const std::vector<HopCounts>& hops) {
  Json report = now;
  const double seconds = json_number_of(now, "seconds") - json_number_of(before, "seconds");
  report["seconds"] = seconds;
  const Json kNone = Json::object();
  report["counters"] =
      subtract_counters(before.contains("counters") ? before["counters"] : kNone, now.contains("counters") ? now["counters"] : kNone);
  for (const auto& [rate, counter] : {std::pair{"samples", "samples"}, std::pair{"forces", "forces"},
                                      std::pair{"vision_sent", "vision_sent"}, std::pair{"drawn", "drawn"}}) {
    report["rates_hz"][rate] = seconds > 0.0 ? json_number_of(report["counters"], counter) / seconds : 0.0;
  }
  report["hops"] = Json::object();
  for (const HopCounts& hop : hops) report["hops"][hop.name] = hop_json(hop);
  report["ratios"] = Json::object();
  add_ratio(report, "round_trip_over_echo_p50", "p50_us");
  add_ratio(report, "round_trip_over_echo_p99", "p99_us");
  return report;
}

}  // namespace hapton
