#include "core/effects/space_effect.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

// The hand tows MassEffect through a damper: the mass gives back no more energy than it got, and the damper takes some.
TEST(SpaceEffect, StatesItsPassivityAndItsBound) {
  EXPECT_EQ(passivity_of(SpringEffect()), Passivity::conservative);
  EXPECT_EQ(passivity_of(SnapEffect()), Passivity::conservative);
  EXPECT_EQ(passivity_of(GravityWellEffect()), Passivity::conservative);
  EXPECT_EQ(passivity_of(ViscousEffect()), Passivity::dissipative);
  EXPECT_EQ(passivity_of(MassEffect()), Passivity::dissipative);
  EXPECT_EQ(passivity_of(ConstantEffect()), Passivity::conservative);
  EXPECT_EQ(passivity_of(ConstantEffect{.volume = EffectVolume::ball(Vec3::Zero(), 1.0)}), Passivity::active);
  EXPECT_EQ(passivity_of(WaveEffect()), Passivity::active);
  EXPECT_EQ(passivity_of(BurstEffect()), Passivity::active);
  EXPECT_EQ(bound_of(SpringEffect{.max_force_n = 1.5}), 1.5);
  EXPECT_EQ(bound_of(ConstantEffect{.force_n = {3, 4, 0}}), 5.0);
  EXPECT_EQ(bound_of(MassEffect{.max_force_n = 2.5}), 2.5);
  EXPECT_EQ(bound_of(WaveEffect{.amplitude_n = 0.25}), 0.25);
}

TEST(SpaceEffect, SwitchedWithAButtonAConservativeOneIsActive) {
  EXPECT_EQ(SwitchedEffect(SpringEffect()).passivity(), Passivity::conservative);
  EXPECT_EQ(SwitchedEffect(SpringEffect(), EffectSwitch{.button = 1}).passivity(), Passivity::active);
  EXPECT_EQ(SwitchedEffect(ViscousEffect(), EffectSwitch{.button = 1}).passivity(), Passivity::dissipative);
}

}  // namespace
}  // namespace hapton
