#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "core/force/friction_drag.h"
#include "tests/core/force/sphere/sphere_stage.h"
#include "tests/support/allocation_guard.h"

// SphereFollower under Coulomb friction.
namespace hapton {
namespace {

constexpr Material kRubs{.friction_static = 0.5, .friction_dynamic = 0.3};

TEST(SphereFollowerWithFriction, SticksExactlyInsideTheCone) {
  Stage stage(made::sphere(0.4, 16, 0.05), 0.03, kRubs);
  stage.put({0.3, 0.4, 0.5});
  stage.move(0.39 * Vec3(0.3, 0.4, 0.5).normalized());
  ASSERT_FALSE(stage.follower->is_free());
  const Vec3 before = stage.follower->centre();
  const Vec3 out = (before - stage.device).normalized();
  const Vec3 aside = out.unitOrthogonal();
  for (int i = 0; i < 200; ++i) {
    const double depth = (before - stage.device).norm();
    const double turn = 0.1 * i;
    const Vec3 way = 0.1 * depth * (std::cos(turn) * aside + std::sin(turn) * out.cross(aside));
    ASSERT_EQ(stage.move_local(before - 0.02 * (1.0 + 0.5 * std::sin(0.3 * i)) * out + way * (0.02 / depth)), Outcome::settled);
    ASSERT_EQ(stage.follower->centre(), before) << "step " << i;
  }
}

// Over a sheet of many faces: what a point of a plane does, in closed form.
TEST(SphereFollowerWithFriction, OverAPlaneItIsDraggedAsInClosedForm) {
  Stage stage(made::sheet(0.5, 0.0, 13), kOffset, kRubs);
  stage.put({0.03, 0.02, 0.4});
  ASSERT_EQ(stage.move({0.03, 0.02, 0.0}), Outcome::settled);
  FrictionDrag expected;
  Vec3 device(0.03, 0.02, 0.0);
  for (int i = 0; i < 300; ++i) {
    const Vec3 to(0.3 * std::cos(0.31 * i), 0.3 * std::sin(0.17 * i), -0.05 - 0.04 * std::sin(0.7 * i));
    const Vec3 motion(to.x() - device.x(), to.y() - device.y(), 0.0);
    expected = drag_by_friction({.pull = expected.pull,
                                 .motion = motion,
                                 .pressure_start = kOffset - device.z(),
                                 .pressure_end = kOffset - to.z(),
                                 .friction_static = kRubs.friction_static,
                                 .friction_dynamic = kRubs.friction_dynamic,
                                 .sliding = expected.sliding});
    ASSERT_EQ(stage.move(to), Outcome::settled);
    ASSERT_LT((stage.centre() - (Vec3(to.x(), to.y(), kOffset) - expected.pull)).norm(), 1e-11) << "step " << i;
    ASSERT_EQ(stage.follower->slides(), expected.sliding) << "step " << i;
    device = to;
  }
}

TEST(SphereFollowerWithFriction, InACornerOfThreeWallsItStays) {
  TriangleMesh room = made::box(Vec3::Zero(), Vec3::Ones());
  for (Triangle& triangle : room.triangles) std::swap(triangle[1], triangle[2]);
  Stage stage(room, kOffset, {.friction_static = 0.3, .friction_dynamic = 0.2, .two_sided = false});
  stage.put({0.4, 0.5, 0.6});
  ASSERT_EQ(stage.move({-0.1, -0.2, -0.3}), Outcome::settled);
  ASSERT_EQ(stage.move({-1.0, -1.0, -1.0}), Outcome::settled);
  expect_centre(stage, Vec3::Constant(kOffset));
  ASSERT_EQ(stage.follower->contacts().size(), 3U);
  // Along one edge of the room: it stays behind by mu times the depth.
  ASSERT_EQ(stage.move({-0.2, 0.6, -0.3}), Outcome::settled);
  const double pull = 0.2 * std::hypot(0.3, 0.4);
  EXPECT_LT((stage.centre() - Vec3(kOffset, 0.6 - pull, kOffset)).norm(), 1e-11) << stage.centre().transpose();
  EXPECT_TRUE(stage.follower->slides());
  // A little back: it stays.
  const Vec3 there = stage.follower->centre();
  ASSERT_EQ(stage.move({-0.2, 0.6 - 0.5 * pull, -0.3}), Outcome::settled);
  EXPECT_EQ(stage.follower->centre(), there);
}

class OverBumpsWithFriction : public testing::TestWithParam<std::tuple<std::uint64_t, double, double>> {};

TEST_P(OverBumpsWithFriction, OneStepIsTheSameMotionInParts) {
  constexpr double kStiffness = 1000.0;  // N/m
  constexpr int kSteps = 160;
  const auto [seed, static_mu, dynamic_mu] = GetParam();
  RecordProperty("seed", std::to_string(seed));
  Stage stage(made::sphere(0.4, 16, 0.05), 0.03, {.friction_static = static_mu, .friction_dynamic = dynamic_mu});
  Wanderer wanderer(seed);
  stage.put({0.3, 0.5, 0.7});
  int touching = 0;
  int slides = 0;
  int several = 0;
  double worst = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 from = stage.device;
    const Vec3 to = stage.geometry.to_local(wanderer.next(i % 4 == 0 ? 0.2 : 0.05));
    SphereFollower in_parts(*stage.follower);
    ASSERT_EQ(stage.move_local(to), Outcome::settled) << "step " << i;
    ASSERT_GE(stage.distance_to_nearest(), stage.offset - kSlop) << "step " << i;
    ASSERT_TRUE(follow_in_parts(in_parts, from, to)) << "step " << i;
    const double error = kStiffness * stage.unit() * (stage.follower->centre() - in_parts.centre()).norm();
    const double force = kStiffness * stage.unit() * (stage.follower->centre() - to).norm();
    worst = std::max(worst, error / std::max(1.0, force));
    ASSERT_LE(error, 1e-8 * std::max(1.0, force)) << "N, step " << i;
    touching += stage.follower->is_free() ? 0 : 1;
    slides += stage.follower->slides() ? 1 : 0;
    several += stage.follower->contacts().size() > 1 ? 1 : 0;
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_GT(touching, kSteps / 2);
  EXPECT_GT(slides, kSteps / 4);
  RecordProperty("several", several);
}

INSTANTIATE_TEST_SUITE_P(Seeds, OverBumpsWithFriction,
                         testing::Combine(testing::Values(1, 2, 3, 4), testing::Values(0.5), testing::Values(0.5, 0.3)));

TEST(SphereFollowerWithFriction, UsesNoHeap) {
  Stage stage(made::sphere(0.4, 16, 0.05), 0.03, kRubs);
  Wanderer wanderer(7);
  stage.put({0.3, 0.5, 0.7});
  std::vector<Vec3> way;
  for (int i = 0; i < 100; ++i) way.push_back(stage.geometry.to_local(wanderer.next(0.05)));
  const AllocationGuard guard;
  for (const Vec3& to : way) stage.move_local(to);
  EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
}

}  // namespace
}  // namespace hapton
