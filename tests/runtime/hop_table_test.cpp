#include "runtime/hop_table.h"

#include <gtest/gtest.h>

#include "runtime/report.h"

namespace hapton {
namespace {

TEST(HopTable, HasALineForEachHopThatWasMeasured) {
  LatencyHop wire{"wire", {}};
  for (int n = 1; n <= 1000; ++n) wire.histogram.record(n * 1000);
  const HopRow row = make_hop_row(wire);
  EXPECT_EQ(row.n, 1000U);
  EXPECT_NEAR(row.p50_us, 500.0, 5.0);
  EXPECT_NEAR(row.p99_9_us, 999.0, 10.0);
  EXPECT_EQ(row.max_us, 1000.0);
  EXPECT_EQ(make_hop_table({{.name = "wire", .n = 7, .p50_us = 1.5, .p90_us = 2.0, .p99_us = 3.0, .p99_9_us = 4.0, .max_us = 1234.567},
                            make_hop_row({"drawn", {}})}),
            "us                        n       p50       p90       p99     p99.9       max\n"
            "wire                      7      1.50      2.00      3.00      4.00   1234.57\n");
}

TEST(HopTable, IsEmptyWhereNothingWasMeasured) {
  EXPECT_EQ(make_hop_table({}), "");
  EXPECT_EQ(make_hop_table({make_hop_row({"drawn", {}})}), "");
}

}  // namespace
}  // namespace hapton
