// A ball on a floor leans on a slanted ridge. The curve where both hold it is an ellipse, and a minimum on it vanishes where the device
// leaves the evolute of the ellipse, which is known in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "tests/core/force/sphere/sphere_stage.h"

namespace hapton {
namespace {

constexpr double kSineOfRidge = 0.5;  // of its angle with the floor
constexpr double kSemiMajor = kStageOffset / kSineOfRidge;
constexpr double kDeviceHeight = -0.3;  // z of the device; if it were less deep, the ridge would lift the ball off the floor
// Distance from the evolute, as a share of its y; even nearer, the barrier is too low to hold a minimum.
constexpr double kNearEvolute = 1e-5;

// The ridge goes up along x, through the middle of the ball's plane.
TriangleMesh floor_with_ridge() {
  TriangleMesh mesh = made::sheet(0.5, 0.0, 5);
  const Vec3 middle(0.0, 0.0, kStageOffset);
  const Vec3 along(std::sqrt(1.0 - kSineOfRidge * kSineOfRidge), 0.0, kSineOfRidge);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(middle - 0.3 * along);
  mesh.vertices.push_back(middle + 0.5 * along);
  mesh.vertices.push_back({0.433, 0.0, -0.05});
  mesh.triangles.push_back({first, first + 1, first + 2});
  return mesh;
}

// (a x)^(2/3) + (b y)^(2/3) = (a^2 - b^2)^(2/3)
double evolute_at(double x) {
  const double all = std::cbrt(std::pow(kSemiMajor * kSemiMajor - kStageOffset * kStageOffset, 2));
  const double of_x = std::cbrt(std::pow(kSemiMajor * x, 2));
  return std::pow(all - of_x, 1.5) / kStageOffset;
}

class VanishingMinimum : public ::testing::TestWithParam<double> {
 protected:
  VanishingMinimum() {
    stage_.put({x_, -0.3, 0.4});
    EXPECT_EQ(stage_.move({x_, -0.3, kDeviceHeight}), Outcome::settled);
    EXPECT_EQ(stage_.move({x_, -0.05, kDeviceHeight}), Outcome::settled);
  }
  void move_to(double y) { EXPECT_EQ(stage_.move({x_, y, kDeviceHeight}), Outcome::settled); }
  void expect_on_ellipse_at_minimum() const {
    const Vec3 c = stage_.centre();
    const Vec3 pull = stage_.geometry.to_scene(stage_.device) - c;
    EXPECT_NEAR(std::hypot(c.x() / kSemiMajor, c.y() / kStageOffset), 1.0, 1e-9);
    EXPECT_NEAR(c.z(), kStageOffset, 1e-9);
    const Vec3 tangent = Vec3(-c.y() * kSemiMajor / kStageOffset, c.x() * kStageOffset / kSemiMajor, 0.0).normalized();
    EXPECT_NEAR(tangent.dot(pull), 0.0, 1e-9);
    EXPECT_GE(stage_.distance_to_nearest(), stage_.offset - kSlop);
  }

  const double x_ = GetParam();
  const double evolute_y_ = evolute_at(x_);
  Stage stage_{floor_with_ridge(), kStageOffset};
};

TEST_P(VanishingMinimum, HoldsUpToTheEvoluteAndNotBeyond) {
  move_to(0.5 * evolute_y_);
  expect_on_ellipse_at_minimum();
  move_to((1.0 - kNearEvolute) * evolute_y_);
  expect_on_ellipse_at_minimum();
  EXPECT_LT(stage_.centre().y(), 0.0);
  move_to((1.0 + kNearEvolute) * evolute_y_);
  expect_on_ellipse_at_minimum();
  EXPECT_GT(stage_.centre().y(), 0.0);
}

TEST_P(VanishingMinimum, IsPassedInFewEventsFromHoweverFar) {
  const std::uint64_t before = stage_.follower->events();
  move_to(1.01 * evolute_y_);
  expect_on_ellipse_at_minimum();
  EXPECT_GT(stage_.centre().y(), 0.0);
  EXPECT_LE(stage_.follower->events() - before, 40U);
}

// The place where the centre jumps depends on the path of the device alone.
TEST_P(VanishingMinimum, PartsOfTheMotionEndWhereTheWholeDoes) {
  Stage whole(floor_with_ridge(), kStageOffset);
  whole.put({x_, -0.3, 0.4});
  ASSERT_EQ(whole.move({x_, -0.3, kDeviceHeight}), Outcome::settled);
  ASSERT_EQ(whole.finish(whole.geometry.to_local({x_, 1.1 * evolute_y_, kDeviceHeight})), Outcome::settled);
  const Vec3 to = stage_.geometry.to_local({x_, 1.1 * evolute_y_, kDeviceHeight});
  ASSERT_TRUE(follow_in_parts(*stage_.follower, stage_.device, to));
  EXPECT_LT((whole.centre() - stage_.centre()).norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Devices, VanishingMinimum, ::testing::Values(-0.06, -0.08, -0.1, -0.12),
                         [](const auto& device) { return "X" + std::to_string(static_cast<int>(-100.0 * device.param)); });

}  // namespace
}  // namespace hapton
