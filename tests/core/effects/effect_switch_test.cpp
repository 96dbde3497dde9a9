#include "core/effects/effect_switch.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hapton {
namespace {

TEST(EffectSwitch, WithoutAButtonIsAlwaysOn) {
  EffectSwitch::State state;
  EXPECT_FALSE(EffectSwitch().update(0, 0.0, state));
  EXPECT_EQ(state.gain, 1.0);
  EXPECT_FALSE(EffectSwitch().update(~0U, 1.0, state));
  EXPECT_EQ(state.gain, 1.0);
}

// The gain in closed form: (t - press) / ramp up to 1, and down again from the release.
TEST(EffectSwitch, RisesFromThePressAndFallsFromTheRelease) {
  constexpr double kStepS = 1e-3;
  const EffectSwitch on{.button = 4};
  EffectSwitch::State state;
  for (int n = 0; n < 200; ++n) {
    const double time_s = kStepS * n;
    const bool is_down = n >= 10 && n < 100;
    EXPECT_EQ(on.update(is_down ? 5U : 1U, time_s, state), n == 10) << n;
    const double up = std::clamp((time_s - 0.01) / EffectSwitch::kRampS, 0.0, 1.0);
    const double down = std::clamp((time_s - 0.1) / EffectSwitch::kRampS, 0.0, 1.0);
    EXPECT_NEAR(state.gain, up - down, 1e-12) << n;
  }
  EXPECT_NEAR(state.began_s, 0.01, 1e-15);
}

TEST(EffectSwitch, AShortPressRaisesTheGainOnlyInPart) {
  const EffectSwitch on{.button = 1};
  EffectSwitch::State state;
  on.update(0, 0.0, state);
  on.update(1, 0.001, state);
  on.update(1, 0.003, state);
  on.update(1, 0.005, state);
  on.update(0, 0.006, state);
  EXPECT_NEAR(state.gain, 0.25, 1e-12);
  on.update(1, 0.008, state);
  EXPECT_NEAR(state.gain, 0.15, 1e-12) << "it fell until the next press";
  on.update(1, 0.010, state);
  EXPECT_NEAR(state.gain, 0.25, 1e-12);
}

TEST(EffectSwitch, ALateSampleChangesTheGainNoMoreThanOneInTime) {
  const EffectSwitch on{.button = 1};
  EffectSwitch::State state;
  on.update(0, 0.0, state);
  on.update(1, 0.001, state);
  on.update(1, 0.5, state);
  EXPECT_NEAR(state.gain, EffectSwitch::kMaxStepS / EffectSwitch::kRampS, 1e-12);
  for (double time_s = 0.501; time_s < 0.53; time_s += 0.001) on.update(1, time_s, state);
  ASSERT_EQ(state.gain, 1.0);
  on.update(0, 0.53, state);
  on.update(0, 1.0, state);
  EXPECT_NEAR(state.gain, 1.0 - EffectSwitch::kMaxStepS / EffectSwitch::kRampS, 1e-9);
}

TEST(EffectSwitch, AButtonThatWasDownBeforeTheStartMustBePressedAgain) {
  const EffectSwitch on{.button = 2};
  EffectSwitch::State state;
  for (int n = 0; n < 50; ++n) EXPECT_FALSE(on.update(2, 1e-3 * n, state));
  EXPECT_EQ(state.gain, 0.0);
  EXPECT_FALSE(on.update(0, 0.05, state));
  EXPECT_TRUE(on.update(2, 0.051, state));
}

}  // namespace
}  // namespace hapton
