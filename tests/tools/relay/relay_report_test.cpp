#include "tools/relay/relay_report.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

// The table and the JSON take the counters from the same list; this test reads the JSON.
TEST(RelayReport, EachCounterHasTheNumberOfItsName) {
  const RelayCounts counts{.received = 1,
                           .forwarded = 2,
                           .lost = 3,
                           .lost_in_burst = 4,
                           .partitioned = 5,
                           .held_back = 6,
                           .duplicated = 7,
                           .corrupted = 8,
                           .overflowed = 9,
                           .rejected = 10,
                           .send_failures = 11};
  EXPECT_EQ(relay_counts_json(counts).dump(),
            R"({"received":1,"forwarded":2,"lost":3,"lost_in_burst":4,"partitioned":5,"held_back":6,"duplicated":7,"corrupted":8,)"
            R"("overflowed":9,"rejected":10,"send_failures":11})");
}

TEST(RelayReport, AReportIsIndentedJsonThatEndsItsLine) {
  const Result<RelayEndpoint> relay = RelayEndpoint::open({.listen = "127.0.0.1:0", .hub = {}, .schedule = {}, .seed = 42});
  ASSERT_TRUE(relay);
  const std::string report = relay_json(*relay, 42, 1.5);
  const std::string_view begins =
      "{\n  \"schema\": \"hapton.relay/2\",\n  \"seed\": 42,\n  \"seconds\": 1.5,\n  \"nodes_seen\": 0,\n  \"to_hub\": {\n    "
      "\"received\": 0,\n";
  EXPECT_EQ(report.substr(0, begins.size()), begins);
  EXPECT_EQ(report.substr(report.size() - 4), "}\n}\n");
}

}  // namespace
}  // namespace hapton
