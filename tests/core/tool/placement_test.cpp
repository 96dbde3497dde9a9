#include "core/tool/placement.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace hapton {
namespace {

TEST(Placement, TurnsAreTheInverseOfEachOther) {
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

TEST(Placement, NoPointMovesFartherThanTheLengthOfTheMotion) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  for (int n = 0; n < 1000; ++n) {
    const RigidMotion motion{{draw(), turn_by(draw())}, 0.3 * draw(), 0.3 * draw()};
    const Vec3 r = draw();
    const double length = motion.length(r.norm());
    for (const double time : {0.1, 0.5, 1.0}) {
      ASSERT_LE((motion.at(time).at(r) - motion.from.at(r)).norm(), time * length * (1.0 + 1e-12));
    }
    ASSERT_LE((motion.scaled(0.5).at(1.0).at(r) - motion.at(0.5).at(r)).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace hapton
