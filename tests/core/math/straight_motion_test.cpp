#include "core/math/straight_motion.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(StraightMotion, EndsExactlyAtItsEnd) {
  const Vec3 from(0.1, -0.2, 0.3);
  const Vec3 to(0.7, 1e-9, -5.0);
  EXPECT_EQ(on_path(from, to, 0.0), from);
  EXPECT_EQ(on_path(from, to, 1.0), to);
  EXPECT_EQ(on_path(from, to, 2.0), to);
  EXPECT_LT((on_path(from, to, 0.5) - 0.5 * (from + to)).norm(), 1e-15);
}

TEST(StraightMotion, PassesZeroWhereTheLineDoesAndNotBeforeNow) {
  EXPECT_DOUBLE_EQ(time_of_zero(1.0, -3.0, 0.0), 0.25);
  EXPECT_DOUBLE_EQ(time_of_zero(1.0, -3.0, 0.5), 0.5);
  EXPECT_DOUBLE_EQ(time_of_zero(2.0, 2.0, 0.75), 0.75);
  EXPECT_DOUBLE_EQ(time_of_zero(-1.0, -2.0, 0.25), 0.25);
}

}  // namespace
}  // namespace hapton
