#include "core/effects/waveform.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

TEST(Waveform, HasItsValuesAtTheQuarters) {
  const double phase[4] = {0.0, 0.25, 0.5, 0.75};
  const double sine[4] = {0, 1, 0, -1};
  const double square[4] = {1, 1, -1, -1};
  const double triangle[4] = {0, 1, 0, -1};
  const double sawtooth[4] = {-1, -0.5, 0, 0.5};
  for (int k = 0; k < 4; ++k) {
    for (const double cycles : {0.0, 3.0, 1000.0}) {
      EXPECT_NEAR(waveform_at(Waveform::sine, cycles + phase[k]), sine[k], 1e-12);
      EXPECT_EQ(waveform_at(Waveform::square, cycles + phase[k]), square[k]);
      EXPECT_EQ(waveform_at(Waveform::triangle, cycles + phase[k]), triangle[k]);
      EXPECT_EQ(waveform_at(Waveform::sawtooth, cycles + phase[k]), sawtooth[k]);
    }
  }
  EXPECT_NEAR(waveform_at(Waveform::triangle, 0.375), 0.5, 1e-12);
  EXPECT_NEAR(waveform_at(Waveform::triangle, 0.875), -0.5, 1e-12);
}

TEST(Waveform, StaysBetweenMinusOneAndOne) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const Waveform form : {Waveform::sine, Waveform::square, Waveform::triangle, Waveform::sawtooth}) {
    for (const double cycles : {0.1, 7.77, 1e6 + 0.3, 1e15, 1e300}) EXPECT_LE(std::abs(waveform_at(form, cycles)), 1.0);
    EXPECT_EQ(waveform_at(form, inf), 0.0);
    EXPECT_EQ(waveform_at(form, std::numeric_limits<double>::quiet_NaN()), 0.0);
  }
}

TEST(DecayingSine, FallsByEWithinTheDecay) {
  // A quarter period after each whole period the sine is 1.
  EXPECT_NEAR(decaying_sine(0.0025, 100.0, 0.01), std::exp(-0.25), 1e-12);
  EXPECT_NEAR(decaying_sine(0.0125, 100.0, 0.01), std::exp(-1.25), 1e-12);
  EXPECT_EQ(decaying_sine(0.0, 100.0, 0.01), 0.0);
  EXPECT_EQ(decaying_sine(-1.0, 100.0, 0.01), 0.0);
  EXPECT_EQ(decaying_sine(std::numeric_limits<double>::quiet_NaN(), 100.0, 0.01), 0.0);
}

}  // namespace
}  // namespace hapton
