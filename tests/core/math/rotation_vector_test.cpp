#include "core/math/rotation_vector.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

TEST(RotationVector, TurnsAreTheInverseOfEachOther) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 1000; ++n) {
    const Quat from = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
    const Vec3 turn = Vec3(normal(random), normal(random), normal(random)).normalized() * (3.1 * n / 1000.0);
    ASSERT_LE((turn_between(from, turn_by(turn) * from) - turn).norm(), 1e-12) << n;
  }
  EXPECT_EQ(turn_between(Quat::Identity(), Quat::Identity()), Vec3::Zero());
  EXPECT_LE(turn_between(Quat::Identity(), Quat(-1.0, 0.0, 0.0, 0.0)).norm(), 1e-15) << "the shorter way round";
}

}  // namespace
}  // namespace hapton
