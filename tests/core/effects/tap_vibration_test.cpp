#include "core/effects/tap_vibration.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(TapVibration, RingsWithTheSpeedOfTheImpact) {
  const TapVibration metal = {.ns_per_m = 5, .frequency_hz = 100, .decay_s = 0.02, .max_force_n = 2};
  TapVibration::State state;
  EXPECT_EQ(metal.force(0.1, state), 0.0) << "never tapped";
  metal.begin(0.2, 1.0, state);
  for (const double t : {0.0, 0.001, 0.0025, 0.04}) {
    EXPECT_NEAR(metal.force(1.0 + t, state), 1.0 * std::exp(-t / 0.02) * std::sin(2 * std::numbers::pi * 100 * t), 1e-9);
  }
  metal.begin(9.0, 2.0, state);
  EXPECT_EQ(state.amplitude_n, 2.0) << "at its largest force";
  metal.begin(-0.3, 3.0, state);
  EXPECT_EQ(metal.force(3.0025, state), 0.0) << "outwards";
}

}  // namespace
}  // namespace hapton
