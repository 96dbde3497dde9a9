#include "core/effects/surface_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

template <class ValueAt>
SurfaceImage made_image(int width, int height, ValueAt value_at) {
  std::vector<float> texels;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) texels.push_back(static_cast<float>(value_at(x, y)));
  }
  return {width, height, std::move(texels)};
}

SurfaceImage random_image(int width, int height, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  return made_image(width, height, [&](int, int) { return std::uniform_real_distribution<double>(0, 1)(random); });
}

// The middle of texel i is at (i + 1/2) / width.
TEST(SurfaceImage, ARampIsExact) {
  const SurfaceImage ramp = made_image(64, 32, [](int x, int y) { return 2.0 * x - 3.0 * y; });
  for (double u = 0.05; u < 0.95; u += 0.0137) {
    for (double v = 0.05; v < 0.95; v += 0.0291) {
      const auto sample = ramp.sample(u, v);
      EXPECT_NEAR(sample.value, 2.0 * (64.0 * u - 0.5) - 3.0 * (32.0 * v - 0.5), 1e-10);
      EXPECT_NEAR(sample.gradient.x(), 128.0, 1e-9);
      EXPECT_NEAR(sample.gradient.y(), -96.0, 1e-9);
    }
  }
}

TEST(SurfaceImage, ASineHasTheHeightThatTheHeaderStates) {
  for (const int texels : {8, 32, 128}) {
    const SurfaceImage sine = made_image(texels, 4, [&](int x, int) { return std::sin(kTwoPi * (x + 0.5) / texels); });
    const double amplitude = std::pow(std::cos(std::numbers::pi / texels), 2);
    for (double u = 0.0; u < 1.0; u += 0.00391) {
      const auto sample = sine.sample(u, 0.3);
      EXPECT_NEAR(sample.value, std::sin(kTwoPi * u), 1.0 - amplitude + 1e-6) << texels;
      EXPECT_NEAR(sample.gradient.x(), kTwoPi * std::cos(kTwoPi * u), kTwoPi * (1.0 - amplitude + 1e-5)) << texels;
    }
    EXPECT_GE(sine.sample(0.25, 0.0).value, amplitude - 1e-6);
  }
}

TEST(SurfaceImage, RepeatsInBothDirections) {
  const SurfaceImage image = random_image(7, 5, 3);
  for (double u = 0.01; u < 1.0; u += 0.0877) {
    const auto expected = image.sample(u, 0.43);
    for (const double turns : {-3.0, 1.0, 1000.0}) {
      EXPECT_NEAR(image.sample(u + turns, 0.43).value, expected.value, 1e-9);
      EXPECT_NEAR(image.sample(u, 0.43 + turns).value, expected.value, 1e-9);
    }
  }
}

// Value and gradient are continuous over texel borders and over the image's edges, and the gradient is that of the value.
TEST(SurfaceImage, IsSmoothEverywhere) {
  const SurfaceImage image = random_image(9, 6, 4);
  constexpr double kStep = 1e-7;
  for (double u = -0.2; u < 1.2; u += 1.0 / 36.0) {
    for (double v = -0.2; v < 1.2; v += 1.0 / 24.0) {
      const auto a = image.sample(u - kStep, v - kStep);
      const auto b = image.sample(u + kStep, v + kStep);
      EXPECT_NEAR(a.value, b.value, 1e-4);
      EXPECT_LT((a.gradient - b.gradient).norm(), 1e-3);
      EXPECT_NEAR((b.value - a.value) / (2.0 * kStep), image.sample(u, v).gradient.sum(), 1e-4);
    }
  }
}

TEST(SurfaceImage, IsNowhereSteeperThanStated) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SurfaceImage image = random_image(16, 11, seed);
    const auto steepest = image.steepest();
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    double largest_share = 0.0;
    for (int n = 0; n < 20000; ++n) {
      const auto sample = image.sample(unit(random), unit(random));
      EXPECT_LE(std::abs(sample.gradient.x()), steepest.x() * (1.0 + 1e-12));
      EXPECT_LE(std::abs(sample.gradient.y()), steepest.y() * (1.0 + 1e-12));
      EXPECT_GE(sample.value, 0.0);
      EXPECT_LE(sample.value, 1.0);
      largest_share = std::max(largest_share, std::abs(sample.gradient.x()) / steepest.x());
    }
    EXPECT_GT(largest_share, 0.5) << "the stated slope is nearly reached";
  }
}

TEST(SurfaceImage, HalvedIsTheMeanAndLessSteep) {
  const SurfaceImage image = random_image(16, 8, 7);
  const SurfaceImage half = image.halved();
  EXPECT_EQ(half.width(), 8);
  EXPECT_EQ(half.height(), 4);
  EXPECT_FLOAT_EQ(half.texels()[0], 0.25F * (image.texels()[0] + image.texels()[1] + image.texels()[16] + image.texels()[17]));
  EXPECT_LT(half.steepest().x(), image.steepest().x());
  SurfaceImage smallest = random_image(5, 3, 8);
  for (int n = 0; n < 5; ++n) smallest = smallest.halved();
  EXPECT_EQ(smallest.width(), 1);
  EXPECT_EQ(smallest.height(), 1);
  EXPECT_EQ(smallest.steepest(), Eigen::Vector2d(0, 0));
}

TEST(SurfaceImage, IsFiniteAtAnyPlaceAndUsesNoHeap) {
  const SurfaceImage image = random_image(4, 4, 9);
  const double extreme[] = {
      std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300, -1e300, -0.0, 1.0, -1e-17};
  const AllocationGuard guard;
  for (const double u : extreme) {
    for (const double v : extreme) EXPECT_TRUE(std::isfinite(image.sample(u, v).value));
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
