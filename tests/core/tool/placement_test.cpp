#include "core/tool/placement.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

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

TEST(Placement, ComposesAndInverts) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  for (int n = 0; n < 100; ++n) {
    const Placement a{draw(), turn_by(draw())};
    const Placement b{draw(), turn_by(draw())};
    const Vec3 r = draw();
    ASSERT_LE(((a * b).at(r) - a.at(b.at(r))).norm(), 1e-13);
    ASSERT_LE((a.inverse().at(a.at(r)) - r).norm(), 1e-13);
    // When a body moves past a tool at rest, no point of the tool moves farther relative to the body than relative_travel_bound().
    const Placement tool{draw(), turn_by(draw())};
    const Vec3 before = (a.inverse() * tool).at(r);
    const Vec3 after = (b.inverse() * tool).at(r);
    ASSERT_LE((after - before).norm(), relative_travel_bound(tool, r.norm(), a, b) * (1.0 + 1e-12));
  }
}

}  // namespace
}  // namespace hapton
