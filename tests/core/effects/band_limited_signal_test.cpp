#include "core/effects/band_limited_signal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/effects/white_noise.h"

namespace hapton {
namespace {

// The amplitude of a sine of `frequency` cycles per sample that is read every `samples` samples, from `first` samples on.
double amplitude_read(double frequency, double samples, double first) {
  BandLimitedSignal signal;
  const double stride = BandLimitedSignal::stride_for(samples);
  const double radians_per_sample = 2.0 * std::numbers::pi * frequency;
  double since = first;
  double pushed = 0.0;
  double sine = 0.0, cosine = 0.0;
  int count = 0;
  for (int n = 0; n < 4000; ++n) {
    for (since += samples; since >= 1.0; since -= 1.0) signal.push(std::sin(radians_per_sample * pushed++));
    if (pushed < 300.0) continue;
    const double phase = radians_per_sample * (pushed + since);
    sine += signal.at(since, stride) * std::sin(phase);
    cosine += signal.at(since, stride) * std::cos(phase);
    ++count;
  }
  return 2.0 * std::hypot(sine, cosine) / count;
}

TEST(BandLimitedSignal, KeepsTheBandOfTheLowerRate) {
  for (const double samples : {0.1, 0.37, 1.0, 1.03, 1.2, 1.4, 2.0, 2.6, 5.0, 10.0}) {
    const double half_lower = 0.5 / BandLimitedSignal::stride_for(samples);
    for (const double share : {0.03, 0.2, 0.41, 0.63, 0.77, 0.9}) {
      EXPECT_NEAR(20.0 * std::log10(amplitude_read(share * half_lower, samples, 0.29)), 0.0, 0.2) << samples << " " << share;
    }
  }
}

TEST(BandLimitedSignal, LeavesOutWhatTheLowerRateCannotCarry) {
  for (const double samples : {2.0, 5.0, 10.0}) {
    for (const double ratio : {1.1, 1.37, 1.9}) {
      EXPECT_LT(amplitude_read(ratio * 0.5 / samples, samples, 0.29), 0.011) << samples << " " << ratio;
    }
  }
}

// Ratios between two strides. Readings above a stride by kMostAboveStride carry less than the stride lets through.
TEST(BandLimitedSignal, LeavesOutWhatTheLowerRateCannotCarryAtAnyRatio) {
  for (const double samples : {1.1, 1.2, 1.4, 1.6, 2.2, 2.45, 3.4, 4.4, 6.5, 7.5, 8.7}) {
    for (const double ratio : {1.21, 1.37, 1.9}) {
      const double frequency = ratio * 0.5 / samples;
      if (frequency >= 0.5) continue;
      EXPECT_LT(amplitude_read(frequency, samples, 0.29), 0.011) << samples << " " << ratio;
    }
  }
}

TEST(BandLimitedSignal, IsTheSamplesAtTheirTimes) {
  BandLimitedSignal signal;
  for (std::uint64_t n = 0; n < 1000; ++n) {
    signal.push(white_noise(1, n));
    const double expected = n < BandLimitedSignal::kHalfWidth ? 0.0 : white_noise(1, n - BandLimitedSignal::kHalfWidth);
    ASSERT_EQ(signal.at(0.0, 1), expected) << n;
  }
  signal.reset();
  EXPECT_EQ(signal.at(0.3, 1), 0.0);
}

TEST(BandLimitedSignal, IsContinuousWhereASampleArrives) {
  for (const double stride : {1.0, 1.25, 1.5, 2.0, 2.5, 10.0}) {
    BandLimitedSignal signal;
    for (std::uint64_t n = 0; n < 500; ++n) {
      const double before = signal.at(1.0 - 1e-12, stride);
      signal.push(white_noise(2, n));
      EXPECT_NEAR(signal.at(0.0, stride), before, 1e-9) << stride << " " << n;
    }
  }
}

TEST(BandLimitedSignal, TheStrideIsNearTheRatioOfTheRates) {
  EXPECT_EQ(BandLimitedSignal::stride_for(0.1), 1.0);
  EXPECT_EQ(BandLimitedSignal::stride_for(1.4), 1.5);
  EXPECT_EQ(BandLimitedSignal::stride_for(2.1), 2.0);
  EXPECT_EQ(BandLimitedSignal::stride_for(7.0), 8.0);
  EXPECT_EQ(BandLimitedSignal::stride_for(1e9), 10.0);
  for (double samples = 1.0; samples <= 10.0; samples += 0.01) {
    const double stride = BandLimitedSignal::stride_for(samples);
    EXPECT_GE(BandLimitedSignal::kMostAboveStride * stride, samples);
    EXPECT_LE(stride, 1.25 * samples) << "the band is not much narrower than the readings could carry";
  }
}

}  // namespace
}  // namespace hapton
