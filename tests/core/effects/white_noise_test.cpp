#include "core/effects/white_noise.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hapton {
namespace {

TEST(WhiteNoise, HasMeanZeroVarianceOneAndNoCorrelation) {
  constexpr int kCount = 1 << 18;
  for (const std::uint64_t seed : {1, 2, 3}) {
    double sum = 0.0, squares = 0.0, most = 0.0;
    double products[4] = {};
    for (int i = 0; i < kCount; ++i) {
      const double x = white_noise(seed, i);
      sum += x;
      squares += x * x;
      most = std::max(most, std::abs(x));
      for (int lag = 1; lag <= 4; ++lag) products[lag - 1] += x * white_noise(seed, i + lag);
    }
    // Five standard deviations of each mean.
    const double wide = 5.0 / std::sqrt(static_cast<double>(kCount));
    EXPECT_LT(std::abs(sum / kCount), wide) << seed;
    EXPECT_LT(std::abs(squares / kCount - 1.0), 2.0 * wide) << seed;
    for (const double product : products) EXPECT_LT(std::abs(product / kCount), wide) << seed;
    EXPECT_GT(most, 3.0) << seed;
    EXPECT_LT(most, kMaxWhiteNoise) << seed;
  }
}

TEST(WhiteNoise, DependsOnSeedAndIndexAlone) {
  EXPECT_EQ(white_noise(7, 42), white_noise(7, 42));
  EXPECT_NE(white_noise(7, 42), white_noise(7, 43));
  EXPECT_NE(white_noise(7, 42), white_noise(8, 42));
}

}  // namespace
}  // namespace hapton
