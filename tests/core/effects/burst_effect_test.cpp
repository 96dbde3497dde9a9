#include "core/effects/burst_effect.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(BurstEffect, RingsOnceForEachEntry) {
  const BurstEffect burst = {.direction = Vec3::UnitX(),
                             .amplitude_n = 2,
                             .frequency_hz = 100,
                             .decay_s = 0.02,
                             .duration_s = 0.05,
                             .volume = EffectVolume::ball(Vec3::Zero(), 0.01)};
  const Vec3 outside(0.02, 0, 0);
  BurstEffect::State state;
  EXPECT_EQ(burst.force({.p_SD = outside, .time_s = 1.0}, state), Vec3::Zero());
  EXPECT_EQ(burst.force({.p_SD = Vec3::Zero(), .time_s = 1.001}, state), Vec3::Zero()) << "a sine begins at zero";
  const double t = 0.0125;
  const double expected = 2 * std::exp(-t / 0.02);
  EXPECT_NEAR(burst.force({.p_SD = Vec3::Zero(), .time_s = 1.001 + t}, state).x(), expected, 1e-9);
  EXPECT_NEAR(burst.force({.p_SD = outside, .time_s = 1.001 + t}, state).x(), expected, 1e-9) << "it goes on outside";
  EXPECT_EQ(burst.force({.p_SD = outside, .time_s = 1.06}, state), Vec3::Zero()) << "over";
  burst.force({.p_SD = Vec3::Zero(), .time_s = 2.0}, state);
  EXPECT_NEAR(burst.force({.p_SD = Vec3::Zero(), .time_s = 2.0 + t}, state).x(), expected, 1e-9) << "the next entry";
}

TEST(BurstEffect, DoesNotRingWhereTheStepBegins) {
  const BurstEffect burst = {.volume = EffectVolume::ball(Vec3::Zero(), 0.01)};
  BurstEffect::State state;
  for (int k = 0; k < 50; ++k) EXPECT_EQ(burst.force({.p_SD = Vec3::Zero(), .time_s = 1e-3 * k}, state), Vec3::Zero());
}

}  // namespace
}  // namespace hapton
