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

}  // namespace
}  // namespace hapton
