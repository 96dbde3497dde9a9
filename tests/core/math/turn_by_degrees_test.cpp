#include "core/math/turn_by_degrees.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(TurnByDegrees, TurnsAboutOneAxis) {
  EXPECT_LT((turn_by_degrees({90, 0, 0}) * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-15);
  EXPECT_LT((turn_by_degrees({0, 90, 0}) * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-15);
  EXPECT_LT((turn_by_degrees({0, 0, 90}) * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_EQ(turn_by_degrees({0, 0, 0}).coeffs(), Quat::Identity().coeffs());
}

// The turns are about fixed axes, x first: the first one turns y into z, the second one turns z into x.
TEST(TurnByDegrees, TheAxesStayAndXIsFirst) {
  EXPECT_LT((turn_by_degrees({90, 90, 0}) * Vec3::UnitY() - Vec3::UnitX()).norm(), 1e-15);
  EXPECT_LT((turn_by_degrees({90, 90, 90}) * Vec3::UnitY() - Vec3::UnitY()).norm(), 1e-15);
}

}  // namespace
}  // namespace hapton
