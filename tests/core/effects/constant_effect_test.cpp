#include "core/effects/constant_effect.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(ConstantEffect, ActsWithinItsVolume) {
  const ConstantEffect wind = {.force_n = {0, -0.5, 0.1}, .volume = EffectVolume::ball(Vec3::Zero(), 0.01)};
  EXPECT_EQ(wind.force({.p_SD = {0.005, 0, 0}}), Vec3(0, -0.5, 0.1));
  EXPECT_EQ(wind.force({.p_SD = {0.02, 0, 0}}), Vec3::Zero());
  EXPECT_DOUBLE_EQ(wind.bound_n(), std::sqrt(0.26));
  const ConstantEffect weight = {.force_n = {0, -0.5, 0}};
  EXPECT_EQ(weight.force({.p_SD = {5, 5, 5}}), Vec3(0, -0.5, 0));
}

}  // namespace
}  // namespace hapton
