#include "runtime/prometheus_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>

namespace hapton {
namespace {

LatencyReport prometheus_sample_report() {
  LatencyReport report;
  report.seconds = 2.5;
  report.counters = {{"lost", 3}, {"samples", 2500}, {"loop_waited_us", 2500}, {"longest_release_us", 20}};
  report.rates_hz = {{"samples", 999.5}};
  report.ratios = {{"round_trip_over_echo_p50", 1.25}};
  report.nodes = {{"haptics", "[::1]:4444", 2.0, 2000, 3, 1, 0, 2003, 0}, {"a \"quoted\\ \n role", "x", 0, 0, 0, 0, 0, 0, 0}};
  LatencyHistogram round_trip;
  for (int i = 1; i <= 1000; ++i) round_trip.record(i * 1000);
  report.hops = {{"round_trip", round_trip}, {"empty", {}}};
  return report;
}

// Returns each value by its name and labels, and checks the grammar of the text format, version 0.0.4.
std::map<std::string, double> parse(const std::string& text) {
  static const std::regex kSample(R"re(^([a-zA-Z_:][a-zA-Z0-9_:]*(\{([a-zA-Z_][a-zA-Z0-9_]*="([^"\\]|\\.)*",?)*\})?) ([-+0-9.eE]+)$)re");
  std::map<std::string, double> samples;
  std::set<std::string> type_lines;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (line.starts_with("# TYPE ")) {
      EXPECT_TRUE(type_lines.insert(line).second) << "twice: " << line;
    } else if (!line.starts_with("# HELP ")) {
      EXPECT_TRUE(std::regex_match(line, match, kSample)) << line;
      if (match.empty()) continue;
      EXPECT_TRUE(samples.emplace(match[1], std::stod(match[5])).second) << "twice: " << line;
    }
  }
  return samples;
}

TEST(PrometheusTextTest, HoldsEveryValueInItsGrammar) {
  const auto samples = parse(to_prometheus(prometheus_sample_report()));
  EXPECT_EQ(samples.at("hapton_up_seconds"), 2.5);
  EXPECT_EQ(samples.at("hapton_lost_total"), 3);
  EXPECT_EQ(samples.at("hapton_samples_total"), 2500);
  EXPECT_EQ(samples.at("hapton_rate_hertz{name=\"samples\"}"), 999.5);
  EXPECT_EQ(samples.at("hapton_ratio{name=\"round_trip_over_echo_p50\"}"), 1.25);
  EXPECT_EQ(samples.at("hapton_node_received_total{role=\"haptics\",address=\"[::1]:4444\"}"), 2000);
  EXPECT_EQ(samples.at("hapton_latency_longest_seconds{hop=\"round_trip\"}"), 1e-3);
  EXPECT_EQ(samples.at("hapton_loop_waited_seconds_total"), 0.0025);
  EXPECT_EQ(samples.at("hapton_longest_release_seconds"), 2e-5);
  EXPECT_EQ(samples.at("hapton_latency_seconds_count{hop=\"round_trip\"}"), 1000);
  EXPECT_NEAR(samples.at("hapton_latency_seconds_sum{hop=\"round_trip\"}"), 0.5005, 1e-6);
  EXPECT_EQ(samples.at("hapton_latency_seconds_count{hop=\"empty\"}"), 0);
}

double bucket(const std::map<std::string, double>& samples, const std::string& hop, const std::string& le) {
  return samples.at("hapton_latency_seconds_bucket{hop=\"" + hop + "\",le=\"" + le + "\"}");
}

TEST(PrometheusTextTest, AHistogramCountsWhatIsWithinEachBound) {
  const auto samples = parse(to_prometheus(prometheus_sample_report()));
  EXPECT_NEAR(bucket(samples, "round_trip", "0.0005"), 500, 8) << "a bucket is 1.6 % wide";
  EXPECT_NEAR(bucket(samples, "round_trip", "0.0001"), 100, 2);
  EXPECT_EQ(bucket(samples, "round_trip", "1e-06"), 0) << "the record of 1,000 ns shares its bucket with longer ones";
  EXPECT_EQ(bucket(samples, "round_trip", "0.005"), 1000);
  EXPECT_EQ(bucket(samples, "round_trip", "+Inf"), 1000);
  EXPECT_EQ(bucket(samples, "empty", "+Inf"), 0);
  double before = 0.0;
  for (const char* le : {"1e-06", "2e-06", "5e-06", "1e-05", "2e-05", "5e-05", "0.0001", "0.0002", "0.0005", "0.001",
                         "0.002", "0.005", "0.01",  "0.02",  "0.05",  "0.1",   "0.2",    "0.5",    "1",      "+Inf"}) {
    EXPECT_GE(bucket(samples, "round_trip", le), before) << le;
    before = bucket(samples, "round_trip", le);
  }
}

// Checks the rules of `promtool check metrics`.
TEST(PrometheusTextTest, EachMetricIsTypedAndNamedAsPrometheusRequires) {
  std::istringstream lines(to_prometheus(prometheus_sample_report()));
  std::map<std::string, std::string> types;
  std::set<std::string> names_with_help;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string hash, word, name, type;
    words >> hash >> word >> name >> type;
    if (line.starts_with("# HELP ")) names_with_help.insert(name);
    if (line.starts_with("# TYPE ")) types[name] = type;
    if (line.starts_with("#")) continue;
    std::string sample = line.substr(0, line.find_first_of("{ "));
    for (const char* suffix : {"_bucket", "_sum", "_count"}) {
      const std::string base = sample.substr(0, sample.size() - std::min(sample.size(), std::string(suffix).size()));
      if (sample.ends_with(suffix) && types.contains(base) && types.at(base) == "histogram") sample = base;
    }
    ASSERT_TRUE(types.contains(sample) && names_with_help.contains(sample)) << line;
    EXPECT_EQ(sample.ends_with("_total"), types.at(sample) == "counter") << line;
    for (const char* unit : {"_us", "_ms", "_ns", "_us_total", "_ms_total", "_ns_total", "_gauge", "_counter", "_histogram"})
      EXPECT_FALSE(sample.ends_with(unit)) << line;
  }
}

}  // namespace
}  // namespace hapton
