#include "core/effects/progressive_stiffness.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(ProgressiveStiffness, GrowsWithTheSquareOfTheDepth) {
  const ProgressiveStiffness foam = {.n_per_m2 = 2e5};
  EXPECT_TRUE(foam.is_on());
  EXPECT_EQ(foam.force(0.0), 0.0);
  EXPECT_DOUBLE_EQ(foam.force(0.002), 0.8);
  EXPECT_DOUBLE_EQ(foam.force(0.004), 3.2);
  EXPECT_EQ(foam.force(1e200), kMaxEffectForceN);
  EXPECT_FALSE(ProgressiveStiffness().is_on());
}

}  // namespace
}  // namespace hapton
