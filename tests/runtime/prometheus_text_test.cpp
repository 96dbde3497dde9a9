#include "runtime/prometheus_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace hapton {
namespace {

LatencyReport sample_report() {
  LatencyReport report;
  report.seconds = 2.5;
  report.counters = {{"lost", 3}, {"samples", 2500}};
  report.rates_hz = {{"samples", 999.5}};
  report.ratios = {{"round_trip_over_echo_p50", 1.25}};
  report.nodes = {{"haptics", "[::1]:4444", 2.0, 2000, 3, 1, 0, 2003, 0}, {"a \"quoted\\ \n role", "x", 0, 0, 0, 0, 0, 0, 0}};
  LatencyHistogram round_trip;
  for (int i = 1; i <= 1000; ++i) round_trip.record(i * 1000);
  report.hops = {{"round_trip", round_trip}, {"empty", {}}};
  return report;
}

// Every line by its name and labels. The grammar of the text format, version 0.0.4.
std::map<std::string, double> parse(const std::string& text) {
  static const std::regex kSample(R"re(^([a-zA-Z_:][a-zA-Z0-9_:]*(\{([a-zA-Z_][a-zA-Z0-9_]*="([^"\\]|\\.)*",?)*\})?) ([-+0-9.eE]+)$)re");
  std::map<std::string, double> samples;
  std::set<std::string> typed;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (line.starts_with("# TYPE ")) {
      EXPECT_TRUE(typed.insert(line).second) << "twice: " << line;
    } else if (!line.starts_with("# HELP ")) {
      EXPECT_TRUE(std::regex_match(line, match, kSample)) << line;
      if (match.empty()) continue;
      EXPECT_TRUE(samples.emplace(match[1], std::stod(match[5])).second) << "twice: " << line;
    }
  }
  return samples;
}

TEST(PrometheusTextTest, HoldsEveryValueInItsGrammar) {
  const auto samples = parse(to_prometheus(sample_report()));
  EXPECT_EQ(samples.at("hapton_up_seconds"), 2.5);
  EXPECT_EQ(samples.at("hapton_lost_total"), 3);
  EXPECT_EQ(samples.at("hapton_samples_total"), 2500);
  EXPECT_EQ(samples.at("hapton_rate_hertz{name=\"samples\"}"), 999.5);
  EXPECT_EQ(samples.at("hapton_ratio{name=\"round_trip_over_echo_p50\"}"), 1.25);
  EXPECT_EQ(samples.at("hapton_node_received_total{role=\"haptics\",address=\"[::1]:4444\"}"), 2000);
  EXPECT_NEAR(samples.at("hapton_latency_seconds{hop=\"round_trip\",quantile=\"0.5\"}"), 500e-6, 5e-6);
  EXPECT_NEAR(samples.at("hapton_latency_seconds{hop=\"round_trip\",quantile=\"0.999\"}"), 999e-6, 9e-6);
  EXPECT_NEAR(samples.at("hapton_latency_seconds{hop=\"round_trip\",quantile=\"1\"}"), 1e-3, 1e-9);
  EXPECT_EQ(samples.at("hapton_latency_seconds_count{hop=\"round_trip\"}"), 1000);
  EXPECT_NEAR(samples.at("hapton_latency_seconds_sum{hop=\"round_trip\"}"), 0.5005, 1e-6);
  EXPECT_EQ(samples.at("hapton_latency_seconds_count{hop=\"empty\"}"), 0);
}

}  // namespace
}  // namespace hapton
