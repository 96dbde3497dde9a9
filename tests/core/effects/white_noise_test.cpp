#include "core/effects/white_noise.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hapton {
namespace {

TEST(WhiteNoise, HasMeanZeroVarianceOneAndNoCorrelation) {
  constexpr int kCount = 1 << 18;
  for (const std::uint64_t seed : {1, 2, 3}) {
    double sum = 0.0, sum_of_squares = 0.0, largest = 0.0;
    double products[4] = {};
    for (int i = 0; i < kCount; ++i) {
      const double x = white_noise(seed, i);
      sum += x;
      sum_of_squares += x * x;
      largest = std::max(largest, std::abs(x));
      for (int lag = 1; lag <= 4; ++lag) products[lag - 1] += x * white_noise(seed, i + lag);
    }
    // Five standard deviations of each mean.
    const double tolerance = 5.0 / std::sqrt(static_cast<double>(kCount));
    EXPECT_LT(std::abs(sum / kCount), tolerance) << seed;
    EXPECT_LT(std::abs(sum_of_squares / kCount - 1.0), 2.0 * tolerance) << seed;
    for (const double product : products) EXPECT_LT(std::abs(product / kCount), tolerance) << seed;
    EXPECT_GT(largest, 3.0) << seed;
    EXPECT_LT(largest, kMaxWhiteNoise) << seed;
  }
}

TEST(WhiteNoise, DependsOnSeedAndIndexAlone) {
  EXPECT_EQ(white_noise(7, 42), white_noise(7, 42));
  EXPECT_NE(white_noise(7, 42), white_noise(7, 43));
  EXPECT_NE(white_noise(7, 42), white_noise(8, 42));
}

}  // namespace
}  // namespace hapton
