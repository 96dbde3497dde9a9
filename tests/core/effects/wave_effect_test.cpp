#include "core/effects/wave_effect.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(WaveEffect, FollowsItsFunctionOfTime) {
  WaveEffect wave = {.direction = Vec3::UnitY(), .amplitude_n = 0.8, .frequency_hz = 20};
  for (const double t : {0.0, 0.001, 0.0125, 0.3, 7.77}) {
    EXPECT_NEAR(wave.force({.time_s = t}).y(), 0.8 * std::sin(2 * std::numbers::pi * 20 * t), 1e-9) << t;
  }
  wave.waveform = Waveform::square;
  EXPECT_EQ(wave.force({.time_s = 0.01}), Vec3(0, 0.8, 0));
  EXPECT_EQ(wave.force({.time_s = 0.03}), Vec3(0, -0.8, 0));
  wave.volume = EffectVolume::ball({1, 0, 0}, 0.1);
  EXPECT_EQ(wave.force({.time_s = 0.01}), Vec3::Zero()) << "outside";
}

}  // namespace
}  // namespace hapton
