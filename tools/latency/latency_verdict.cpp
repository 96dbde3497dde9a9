#include "tools/latency/latency_verdict.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/json_number.h"

namespace hapton {
namespace {

constexpr double kRatesHz[] = {1000.0, 4000.0, 10'000.0};  // every report says whether the measured times fit these servo rates

double hop_us(const nlohmann::json& report, const char* hop, const char* quantile) {
  const auto hops = report.value("hops", nlohmann::json::object());
  const auto found = hops.find(hop);
  if (found == hops.end() || json_number_of(*found, "n") == 0.0) return -1.0;
  const auto duration_us = found->find(quantile);
  return duration_us != found->end() && duration_us->is_number() ? duration_us->get<double>() : -1.0;
}

double count(const nlohmann::json& report, const char* name) { return json_number_of(report, "counters", name); }

RateVerdict check_rate(double rate_hz, double need_us) {
  const double margin_us = 1e6 / rate_hz - need_us;
  return {rate_hz, margin_us >= 0.0, margin_us};
}

std::string khz(double rate_hz) { return fmt::format("{:g} kHz", 1e-3 * rate_hz); }

}  // namespace

Result<LatencyVerdict> evaluate_latency(const nlohmann::json& report) {
  if (!report.is_object()) return fail("is not a latency report");
  const double round_trip_us = hop_us(report, "round_trip", "p99_9_us");
  const double samples = count(report, "samples");
  if (round_trip_us < 0.0 || samples <= 0.0) return fail("no force was measured; see the logs beside the report");
  LatencyVerdict verdict;
  verdict.rate_hz = json_number_of(report, "rates_hz", "servo_requested");
  if (!(verdict.rate_hz > 0.0)) return fail("does not contain the servo rate");
  verdict.need_us = round_trip_us + std::max(0.0, hop_us(report, "wake_lateness", "p99_9_us"));
  const double missed = count(report, "late") + count(report, "lost") + count(report, "superseded") + count(report, "missed_cycles");
  verdict.missed_share = missed / (samples + count(report, "missed_cycles"));
  for (const double rate_hz : kRatesHz) verdict.rates.push_back(check_rate(rate_hz, verdict.need_us));
  const RateVerdict measured = check_rate(verdict.rate_hz, verdict.need_us);
  if (!measured.fits) {
    verdict.reason =
        fmt::format("wake-up and round trip take {:.1f} us at p99.9, and a period is {:.1f} us", verdict.need_us, 1e6 / verdict.rate_hz);
  } else if (verdict.missed_share > kMaxMissedShare) {
    verdict.reason = fmt::format("{:.2f} % of the cycles were late, lost, superseded or missed; at most {:g} % are allowed",
                                 100.0 * verdict.missed_share, 100.0 * kMaxMissedShare);
  }
  verdict.holds = verdict.reason.empty();
  return verdict;
}

nlohmann::ordered_json to_json(const LatencyVerdict& verdict) {
  nlohmann::ordered_json json = {{"rate_hz", verdict.rate_hz},
                                 {"holds", verdict.holds},
                                 {"reason", verdict.reason},
                                 {"need_us", verdict.need_us},
                                 {"missed_share", verdict.missed_share},
                                 {"fit_for", nlohmann::ordered_json::array()}};
  for (const RateVerdict& rate : verdict.rates) {
    json["fit_for"].push_back({{"rate_hz", rate.rate_hz}, {"fits", rate.fits}, {"margin_us", rate.margin_us}});
  }
  return json;
}

std::string to_text(const LatencyVerdict& verdict) {
  std::string text = fmt::format("verdict at {}: {}\n", khz(verdict.rate_hz), verdict.holds ? "held" : "not held: " + verdict.reason);
  text += fmt::format("by wake-up and round trip at p99.9 ({:.1f} us together): ", verdict.need_us);
  for (const RateVerdict& rate : verdict.rates) {
    text += fmt::format("{}{} {}", rate.rate_hz == kRatesHz[0] ? "" : ", ", rate.fits ? "fit for" : "not fit for", khz(rate.rate_hz));
  }
  return text + "\n";
}

}  // namespace hapton
