#include "tools/latency/latency_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "runtime/report.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST(LatencyCsv, ReadsWhatAReportWrites) {
  LatencyReport report;
  LatencyHop hop{"round_trip", {}};
  for (int i = 1; i <= 1000; ++i) {
    hop.histogram.record(1000 * i);
  }
  report.hops = {hop, {"bare_echo", {}}};
  const auto hops = parse_latency_csv(to_csv(report), "r.csv");
  ASSERT_TRUE(hops) << hops.error().what;
  ASSERT_EQ(hops->size(), 1U);  // the empty one has no curve
  EXPECT_EQ(hops->front().name, "round_trip");
  EXPECT_EQ(hops->front().total(), 1000U);
  for (const double share : {0.01, 0.5, 0.9, 0.99, 1.0}) {
    EXPECT_NEAR(hops->front().quantile_us(share), 1000.0 * share, 20.0 * share);
  }
}

TEST(LatencyCsv, WhatIsNewIsTheDifferenceOfTwoTables) {
  const auto parse = [](const std::string& rows) { return *parse_latency_csv("hop,lower_ns,upper_ns,count\n" + rows, "r.csv"); };
  const auto before = parse("a,1,2,3\na,5,6,1\nb,1,2,9\nc,1,2,5\n");
  const auto now = parse("a,1,2,3\na,3,4,2\na,5,6,4\nb,1,2,2\nc,1,2,5\nd,7,8,1\n");
  // The counts of b went down: that hop began again.
  EXPECT_EQ(to_csv(subtract_hops(now, before)), "hop,lower_ns,upper_ns,count\na,3,4,2\na,5,6,3\nb,1,2,2\nd,7,8,1\n");
  EXPECT_EQ(to_csv(subtract_hops(now, {})), to_csv(now));
}

TEST(LatencyCsv, NamesTheLineThatIsWrong) {
  const std::string header = "hop,lower_ns,upper_ns,count\n";
  for (const std::string_view row : {"a,1,2", "a,1,2,x", "a,2,1,5", "a,-1,2,5", "a b,1,2,5", "a'; system('x'),1,2,5", ",1,2,5", "a,1,2,5,6",
                                     "a,10,20,1\na,15,30,1", "a,1,2,5\nok,5,6,1"}) {
    const auto hops = parse_latency_csv(header + "ok,1,2,3\n" + std::string(row) + "\n", "r.csv");
    ASSERT_FALSE(hops) << row;
    const bool has_two_lines = row.find('\n') != std::string_view::npos;  // the second one is wrong
    EXPECT_THAT(hops.error().what, HasSubstr(has_two_lines ? "r.csv:4:" : "r.csv:3:")) << row;
  }
  EXPECT_THAT(parse_latency_csv("something\n", "r.csv").error().what, HasSubstr("r.csv:1:"));
  EXPECT_THAT(parse_latency_csv("", "r.csv").error().what, HasSubstr("r.csv:1:"));
  EXPECT_THAT(parse_latency_csv(header, "r.csv").error().what, HasSubstr("no durations"));
  EXPECT_THAT(read_latency_csv("/nonexistent/latency.csv").error().what, HasSubstr("/nonexistent/latency.csv"));
}

}  // namespace
}  // namespace hapton
