#include "core/force/sculpt/field_ball.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kClayVoxelM = 0.001;
constexpr double kToolRadiusM = 0.004;
constexpr double kClayRadiusM = 0.03;

CarvedField field_of(const TriangleMesh& mesh) {
  auto field = CarvedField::make(mesh, kClayVoxelM);
  EXPECT_TRUE(field) << field.error().what;
  return std::move(*field);
}

Vec3 direction_from_clay(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

// The surface of the ball is represented by points. A position on it may be up to half of their spacing away from the nearest point.
constexpr double kPointToleranceM = 0.1 * kClayVoxelM;

TEST(FieldBall, RestsOnABallOfMaterialWhereItIsNearestToTheDevice) {
  const CarvedField field = field_of(make_icosphere(kClayRadiusM, 5));
  const FieldBall ball(kToolRadiusM, kClayVoxelM);
  const std::uint64_t seed = 31;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int i = 0; i < 200; ++i) {
    const Vec3 out = direction_from_clay(random);
    const Vec3 goal = (kClayRadiusM + 0.0035) * out;
    const FieldBall::Moved moved = ball.move(field, 0.05 * out, goal);
    ASSERT_TRUE(moved.touches);
    EXPECT_NEAR(moved.centre.norm(), kClayRadiusM + kToolRadiusM, 2.0 * kPointToleranceM);
    EXPECT_NEAR((moved.normal - out).norm(), 0.0, 0.3);
    EXPECT_LT((moved.centre - moved.centre.dot(out) * out).norm(), kClayVoxelM) << "the place under the device";
    EXPECT_GE(ball.clearance_m(field, moved.centre), -1e-9);
  }
}

TEST(FieldBall, OnAPlaneStopsAtTheClosedFormAndSlidesAlong) {
  const CarvedField field = field_of(make_box(Vec3(0.06, 0.06, 0.02)));
  const FieldBall ball(kToolRadiusM, kClayVoxelM);
  Vec3 centre(-0.02, 0.003, 0.02);
  for (int i = 0; i <= 200; ++i) {
    const Vec3 device(-0.02 + 0.0002 * i, 0.003, 0.01 + kToolRadiusM - 0.002);
    const FieldBall::Moved moved = ball.move(field, centre, device);
    centre = moved.centre;
    ASSERT_TRUE(moved.touches);
    EXPECT_NEAR(centre.z(), 0.01 + kToolRadiusM, kPointToleranceM) << i;
    EXPECT_NEAR(centre.x(), device.x(), 1e-3 * kClayVoxelM) << i;
    EXPECT_NEAR((moved.normal - Vec3::UnitZ()).norm(), 0.0, 1e-3);
  }
  // On a plane the ball always touches with the same of its points: its height does not ripple.
  const double height = centre.z();
  centre = ball.move(field, centre, {-0.0133, 0.0041, 0.012}).centre;
  EXPECT_NEAR(centre.z(), height, 1e-3 * kClayVoxelM);
}

TEST(FieldBall, IsFreeWhereThereIsNoMaterial) {
  const CarvedField field = field_of(make_icosphere(kClayRadiusM, 4));
  const FieldBall ball(kToolRadiusM, kClayVoxelM);
  const Vec3 goal(0.0, 0.036, 0.01);
  const FieldBall::Moved moved = ball.move(field, {0.01, 0.2, 0.0}, goal);
  EXPECT_FALSE(moved.touches);
  EXPECT_EQ(moved.centre, goal);
  EXPECT_EQ(ball.advance(field, {0.3, 0.2, 0.0}, goal, 0.0), goal);
}

// Two carves leave a wall of 0.3 to 1.5 voxels; the device passes through it in one step or in several.
TEST(FieldBall, DoesNotPassAThinWallHoweverFast) {
  const std::uint64_t seed = 33;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> wall(0.3, 1.5), place(-0.3, 0.3), along(-0.004, 0.004);
  for (int i = 0; i < 60; ++i) {
    CarvedField field = field_of(make_box(Vec3(0.05, 0.05, 0.05)));
    // The middle of the wall is on a node, so that the field contains the wall.
    const double middle = field.grid().node(static_cast<int>(field.nodes()[0]) / 2, 0, 0).x();
    const double half = 0.5 * wall(random) * kClayVoxelM;
    const double radius = 0.012;
    field.carve({{middle - half - radius, 0, -0.02}, {middle - half - radius, 0, 0.04}, radius});
    field.carve({{middle + half + radius, 0, -0.02}, {middle + half + radius, 0, 0.04}, radius});
    const FieldBall ball(kToolRadiusM, kClayVoxelM);
    for (const int steps : {1, 3, 10, 100}) {
      Vec3 centre(middle - half - radius, 0.0, 0.0);
      ASSERT_GT(ball.clearance_m(field, centre), 0.0);
      const Vec3 end(middle + half + radius, along(random), along(random));
      const Vec3 start = centre;
      for (int k = 1; k <= steps; ++k) centre = ball.move(field, centre, start + (end - start) * (double(k) / steps)).centre;
      for (int k = 0; k < 20; ++k) centre = ball.move(field, centre, end).centre;
      ASSERT_LT(centre.x(), middle) << "wall " << 2e3 * half << " mm, " << steps << " steps";
    }
  }
}

// While the device stands still, the ball comes to rest.
TEST(FieldBall, SettlesInAPit) {
  CarvedField field = field_of(make_box(Vec3(0.06, 0.06, 0.03)));
  const std::uint64_t seed = 34;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-0.008, 0.008);
  for (int i = 0; i < 40; ++i) field.carve({{place(random), place(random), 0.016}, {place(random), place(random), 0.014}, 0.006});
  const FieldBall ball(kToolRadiusM, kClayVoxelM);
  for (int i = 0; i < 100; ++i) {
    const Vec3 device(place(random), place(random), 0.004);
    Vec3 centre(device.x(), device.y(), 0.03);
    for (int k = 0; k < 60; ++k) centre = ball.move(field, centre, device).centre;
    const Vec3 next = ball.move(field, centre, device).centre;
    EXPECT_LT((next - centre).norm(), 2e-3 * kClayVoxelM) << i;
    EXPECT_LE((next - device).norm(), (centre - device).norm() + 1e-3 * kClayVoxelM);
  }
}

TEST(FieldBall, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  const CarvedField field = field_of(make_icosphere(kClayRadiusM, 4));
  const FieldBall ball(kToolRadiusM, kClayVoxelM);
  const AllocationGuard guard;
  const Vec3 centre = ball.move(field, {0.05, 0.0, 0.0}, {0.02, 0.01, 0.0}).centre;
  ball.advance(field, centre, {0.05, 0.01, 0.0}, 0.0);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
