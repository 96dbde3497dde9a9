#include "safety/slew_limit.h"

#include <gtest/gtest.h>

#include "tools/governor/hostile_program.h"

namespace hapton {
namespace {

TEST(SlewLimit, FollowsAtItsRateAndArrivesExactly) {
  SlewLimit slew;
  EXPECT_NEAR(slew.follow(Vec3(0, 0, 1), 10.0, {0.4, 0.4}).z(), 0.4, 1e-9);
  EXPECT_TRUE(slew.was_limited());
  slew.follow(Vec3(0, 0, 1), 10.0, {0.4, 0.4});
  EXPECT_EQ(slew.follow(Vec3(0, 0, 1), 10.0, {0.4, 0.4}), Vec3(0, 0, 1));
  EXPECT_FALSE(slew.was_limited());
}

TEST(SlewLimit, ReachesTheMagnitudeLimitFirst) {
  SlewLimit slew;
  slew.follow(Vec3(4, 0, 0), 10.0, {10.0, 10.0});
  // The goal is in another direction; the whole step is used to come within the limit.
  const Vec3 v = slew.follow(Vec3(0, 3, 0), 3.0, {1.0, 1.0});
  EXPECT_NEAR(v.x(), 3.0, 1e-9);
  EXPECT_NEAR(v.y(), 0.0, 1e-9);
  // A release may be faster than following.
  EXPECT_NEAR(slew.follow(Vec3(0, 3, 0), 1.0, {0.1, 1.5}).norm(), 1.5, 1e-9);
}

TEST(SlewLimit, ZeroIsReachedExactly) {
  SlewLimit slew;
  slew.follow(Vec3(0.3, 0.1, -0.7), 10.0, {10.0, 10.0});
  for (int n = 0; n < 20; ++n) slew.follow(Vec3::Zero(), 0.0, {0.05, 0.05});
  EXPECT_EQ(slew.value(), Vec3::Zero());
}

TEST(SlewLimit, KeepsLimitAndRatesForAnyGoal) {
  SplitMix random(5);
  SlewLimit slew;
  for (int n = 0; n < 100'000; ++n) {
    const Vec3 before = slew.value();
    const double limit = random.once_in(5) ? 0.0 : random.uniform(0.0, 8.0);
    const SlewLimit::Rates rates{random.uniform(0.0, 1.0), random.uniform(1.0, 2.0)};
    const double size = random.once_in(10) ? 1e300 : 10.0;
    const Vec3 after = slew.follow(random.vector(size), limit, rates);
    ASSERT_TRUE(after.allFinite());
    ASSERT_LE((after - before).norm(), rates.release + 1e-9);
    ASSERT_LE(after.norm(), std::max(limit, before.norm() - rates.release) + 1e-9);
    if ((after - before).norm() > rates.towards_goal + 1e-9) {
      ASSERT_LE(after.norm(), before.norm());
    }
  }
}

TEST(VectorLimit, LengthsAreExactWhereSquaresAreNot) {
  EXPECT_DOUBLE_EQ(length_of(Vec3(3e300, 4e300, 0)), 5e300);
  EXPECT_DOUBLE_EQ(length_of(Vec3(3e-300, 4e-300, 0)), 5e-300);
  EXPECT_EQ(length_of(Vec3::Zero()), 0.0);
  EXPECT_NEAR(shortened(Vec3(3e300, 4e300, 0), 10.0).y(), 8.0, 1e-9);
  EXPECT_EQ(shortened(Vec3(1, 2, 3), 10.0), Vec3(1, 2, 3));
  EXPECT_LE(shortened(Vec3(1e-310, 0, 0), 0.0).norm(), 0.0);
}

}  // namespace
}  // namespace hapton
