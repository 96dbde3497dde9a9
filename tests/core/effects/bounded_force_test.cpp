#include "core/effects/bounded_force.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

TEST(BoundedForce, KeepsWhatIsShortEnoughToTheBit) {
  for (const Vec3& f : {Vec3(0.1, -0.2, 0.3), Vec3(0, 3, 0), Vec3(1.7, 1.7, 1.7), Vec3(5e-324, 0, 0)}) {
    EXPECT_EQ(bounded_force(f, 3.0), f);
  }
}

TEST(BoundedForce, ShortensAlongTheDirection) {
  EXPECT_LT((bounded_force({3, -4, 0}, 1.0) - Vec3(0.6, -0.8, 0)).norm(), 1e-15);
  EXPECT_LT((bounded_force({3e307, -4e307, 0}, 1.0) - Vec3(0.6, -0.8, 0)).norm(), 1e-15) << "whose square overflows";
}

TEST(BoundedForce, GivesNothingForWhatIsNotFinite) {
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Vec3& f : {Vec3(inf, 0, 0), Vec3(0, -inf, 1), Vec3(nan, 1, 1), Vec3(1, 1, nan), Vec3(inf, nan, -inf)}) {
    EXPECT_EQ(bounded_force(f, 3.0), Vec3::Zero());
  }
  EXPECT_EQ(bounded_force(Vec3::Zero(), 3.0), Vec3::Zero());
  EXPECT_EQ(bounded_force(Vec3::Ones(), 0.0), Vec3::Zero());
}

}  // namespace
}  // namespace hapton
