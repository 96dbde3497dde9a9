#include "core/force/sphere/corner_exit.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "tests/support/corner_stage.h"

namespace hapton {
namespace {

// A point in the corner of a room, with other meshes if there are any.
struct PointInCorner : CornerStage {
  explicit PointInCorner(std::vector<const TriangleMesh*> others = {}, TriangleMesh walls = room())
      : CornerStage(0.05, std::move(others), std::move(walls)) {}
  CornerExit corner() { return {contacts, *near, centre, memory, work}; }

  CornerExit::Memory memory;
};

TEST(CornerExitOf, TheFreeDirectionsAreThoseOfTheOctant) {
  PointInCorner point;
  ASSERT_TRUE(point.corner().find_cone(0.0));
  const TangentCone& cone = point.corner().cone();
  EXPECT_LT((cone.apex() - point.apex).norm(), 1e-15);
  for (const double x : {-0.5, 0.3, 1.0}) {
    for (const double y : {-0.2, 0.7}) {
      for (const double z : {-0.9, 0.4}) EXPECT_EQ(cone.contains(Vec3(x, y, z).normalized()), x > 0.0 && y > 0.0 && z > 0.0);
    }
  }
}

// No triangle has a vertex at the corner: the apex is where the planes of the three faces meet.
TEST(CornerExitOf, ThreeFacesThatGoThroughOneAnotherMakeTheSameCorner) {
  PointInCorner point({}, CornerStage::crossing_walls());
  ASSERT_TRUE(point.corner().find_cone(0.0));
  const TangentCone& cone = point.corner().cone();
  EXPECT_LT((cone.apex() - point.apex).norm(), 1e-12);
  EXPECT_TRUE(cone.contains(Vec3(0.3, 0.7, 0.4).normalized()));
  for (const Vec3& outside : {Vec3(-0.5, 0.7, 0.4), Vec3(0.3, -0.2, 0.4), Vec3(0.3, 0.7, -0.9)})
    EXPECT_FALSE(cone.contains(outside.normalized()));
}

// Two faces hold the point, and no vertex is near: the point can slide away.
TEST(CornerExitOf, BetweenTwoFacesThereIsNoCorner) {
  PointInCorner point({}, CornerStage::crossing_walls());
  const OffsetContact two_walls[] = {point.contacts[0], point.contacts[1]};
  point.contacts.hold_by(two_walls);
  EXPECT_FALSE(point.corner().find_cone(0.0));
}

// The pull turns towards the x axis: from the time found on, the way out along that axis leads nearer by more than kMinGain offsets.
TEST(CornerExitOf, TheExitOpensWhenAnEdgeLeadsNearer) {
  PointInCorner point;
  const Vec3 from = point.apex + Vec3(-0.1, -0.2, -0.1);
  const Vec3 to = point.apex + Vec3(0.3, -0.2, -0.1);
  const double exit_time = point.corner().time_to_exit(from, to, 0.0);
  ASSERT_LE(exit_time, 1.0);
  const auto pull_at = [&](double time) { return Vec3(from + time * (to - from) - point.apex); };
  EXPECT_GE(pull_at(exit_time).x(), point.corner().least_exit(pull_at(exit_time)));
  EXPECT_LT(pull_at(exit_time).x(), 1.5 * point.corner().least_exit(pull_at(exit_time)));
  // A way of the length least_exit() along the edge does lead nearer by more than kMinGain offsets.
  const Vec3 out = point.corner().least_exit(pull_at(exit_time)) * Vec3::UnitX();
  EXPECT_LT((pull_at(exit_time) - out).norm(), pull_at(exit_time).norm() - CornerExit::kMinGain * CornerStage::kClearance.offset);
  EXPECT_EQ(point.corner().time_to_exit(from, from - Vec3::UnitX(), 0.0), 2.0);
}

TEST(CornerExitOf, ATargetPastTheCornerIsFreeOnlyWithNothingElseAround) {
  constexpr double kWide = 512.0 * CornerStage::kClearance.offset;
  const Vec3 inwards = Vec3(1.0, 0.5, 0.7).normalized();
  PointInCorner point;
  ASSERT_TRUE(point.corner().find_cone(0.0));
  EXPECT_TRUE(point.corner().can_pass(point.apex + kWide * inwards, kWide));
  EXPECT_FALSE(point.corner().can_pass(point.apex - kWide * inwards, kWide)) << "outside";
  EXPECT_FALSE(point.corner().can_pass(point.apex + kWide * Vec3::UnitX(), kWide)) << "in the walls";
  const TriangleMesh between = made::box(Vec3::Constant(0.003), Vec3::Constant(0.0031));
  PointInCorner beside_box({&between});
  ASSERT_TRUE(beside_box.corner().find_cone(0.0));
  EXPECT_FALSE(beside_box.corner().can_pass(beside_box.apex + kWide * inwards, kWide));
}

TEST(CornerExitOf, APositionPastTheCornerIsOffTheWalls) {
  PointInCorner point;
  ASSERT_TRUE(point.corner().find_cone(0.0));
  const TangentCone::Steepest steepest = point.memory.cone.find_steepest(Vec3(1.0, -0.1, -0.1));
  EXPECT_GT(steepest.slope, 0.0);
  const std::optional<Vec3> target = point.corner().find_past(steepest, 1e-3);
  ASSERT_TRUE(target.has_value());
  EXPECT_GE((*target - point.apex).minCoeff(), CornerStage::kClearance.offset);
  EXPECT_FALSE(point.corner().find_past(steepest, 2.0 * CornerStage::kClearance.offset).has_value()) << "too near";
}

}  // namespace
}  // namespace hapton
