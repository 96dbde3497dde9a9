#include "tools/latency/latency_window.h"

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

namespace hapton {
namespace {

nlohmann::ordered_json report(double seconds, int samples, int longest_us) {
  return {{"schema", "hapton.report/4"},
          {"seconds", seconds},
          {"rates_hz", {{"servo_requested", 1000.0}, {"samples", 1.0}}},
          {"counters", {{"samples", samples}, {"forces", samples / 2}, {"longest_release_us", longest_us}}},
          {"ratios", {{"round_trip_over_echo_p50", 9.0}}},
          {"hops", {{"round_trip", {{"n", 5}}}}}};
}

TEST(LatencyWindow, HoldsTheTimeBetweenTwoReportsOnly) {
  const std::vector<HopCounts> hops = {{"round_trip", {{30'000, 30'200, 90}, {60'000, 60'200, 10}}},
                                       {"bare_echo", {{20'000, 20'200, 100}}}};
  const auto window = make_window_report(report(10, 9'000, 300), report(12, 11'000, 400), hops);
  EXPECT_EQ(window["seconds"], 2.0);
  EXPECT_EQ(window["counters"]["samples"], 2'000);
  EXPECT_EQ(window["counters"]["longest_release_us"], 400);
  EXPECT_EQ(window["rates_hz"]["samples"], 1000.0);
  EXPECT_EQ(window["rates_hz"]["servo_requested"], 1000.0);
  EXPECT_EQ(window["hops"]["round_trip"]["n"], 100);
  EXPECT_NEAR(window["hops"]["round_trip"]["p50_us"].get<double>(), 30.1, 1e-9);
  EXPECT_NEAR(window["hops"]["round_trip"]["max_us"].get<double>(), 60.1, 1e-9);
  EXPECT_NEAR(window["hops"]["round_trip"]["mean_us"].get<double>(), 33.1, 1e-9);
  EXPECT_NEAR(window["ratios"]["round_trip_over_echo_p50"].get<double>(), 30.1 / 20.1, 1e-9);
}

TEST(LatencyWindow, ClaimsNoRatioWithoutAnEcho) {
  const auto window = make_window_report(report(10, 9'000, 0), report(12, 11'000, 0), {{"round_trip", {{30'000, 30'200, 90}}}});
  EXPECT_TRUE(window["ratios"].empty());
}

}  // namespace
}  // namespace hapton
