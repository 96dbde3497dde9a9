#include "core/base/period_ns.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

TEST(PeriodNs, IsTheInverseOfTheRateAndFitsWhateverThatIs) {
  EXPECT_EQ(period_ns(1000.0), 1'000'000);
  EXPECT_EQ(period_ns(60.0), 16'666'667);
  EXPECT_EQ(period_ns(1e-6), 1'000'000'000'000'000);
  for (const double rate_hz : {1e-9, 1e-300, std::numeric_limits<double>::denorm_min()}) {
    EXPECT_EQ(period_ns(rate_hz), 1'000'000'000'000'000'000) << rate_hz;
  }
}

}  // namespace
}  // namespace hapton
