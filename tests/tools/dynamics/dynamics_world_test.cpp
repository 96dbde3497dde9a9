#include "tools/dynamics/dynamics_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/math/rotation_vector.h"
#include "scene/object_motion.h"
#include "tests/tools/dynamics/pushed_scene.h"

namespace hapton::dynamics {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kMu = 0.3;
constexpr double kG = 9.81;

struct Worlds : testing::Test {
  void SetUp() override { make(table_scene()); }
  void make(const Scene& scene, double friction = kMu) {
    auto made = DynamicsWorld::make(scene, friction);
    ASSERT_TRUE(made) << made.error().what;
    world = std::move(*made);
    world->set_gravity({0, -kG, 0});
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / DynamicsWorld::kStepS)); ++i) world->step();
  }
  Vec3 position() const { return world->place(kBox).p_S; }

  std::unique_ptr<DynamicsWorld> world;
};

TEST_F(Worlds, ABoxOnATableStaysWhereItIs) {
  const Vec3 before = position();
  run(3.0);
  EXPECT_LT((position() - before).norm(), 2e-4);  // Bullet's margins
  EXPECT_LT(turn_between(Quat::Identity(), world->place(kBox).turn).norm(), 1e-3);
}

TEST_F(Worlds, WhatFallsGetsFasterUpToTheFastestSurface) {
  make(table_scene({.height_m = 0.1}));
  const double start = position().y();
  run(0.02);
  EXPECT_NEAR(start - position().y(), 0.5 * kG * 0.02 * 0.02, 2e-4);
  const double before = position().y();
  run(0.1);
  EXPECT_NEAR((before - position().y()) / 0.1, kMaxSurfaceSpeed, 1.1 * kG * DynamicsWorld::kStepS);
}

TEST_F(Worlds, FrictionHoldsABoxUpToItsLimit) {
  run(0.2);
  const Vec3 start = position();
  const double limit_n = kMu * kBoxKg * kG;
  world->press(Push{.object = kBox, .p_S = start, .force_n = {0.8 * limit_n, 0, 0}});
  run(0.5);
  EXPECT_LT((position() - start).norm(), 2e-4);
}

// x = (F - mu m g) t^2 / (2 m).
TEST_F(Worlds, BeyondThatLimitABoxSlidesAsNewtonAndCoulombHaveIt) {
  run(0.2);
  const Vec3 start = position();
  const double limit_n = kMu * kBoxKg * kG;
  // At the centre of mass: the box does not tip; its front edge only carries more of the weight, and of the friction, than its rear edge.
  world->press(Push{.object = kBox, .p_S = start, .force_n = {2.0 * limit_n, 0, 0}});
  const double seconds = 0.05;
  run(seconds);
  const double expected_m = 0.5 * limit_n / kBoxKg * seconds * seconds;
  EXPECT_NEAR(position().x() - start.x(), expected_m, 0.06 * expected_m);
  EXPECT_LT(std::abs(position().z() - start.z()), 1e-4);
}

// phi = torque t^2 / (2 I); a cube has I = m a^2 / 6 about each axis.
TEST_F(Worlds, APushBesideTheCentreTurnsTheBox) {
  make(table_scene({.height_m = 0.1}));
  world->set_gravity(Vec3::Zero());
  const Vec3 arm(0, 0, kBoxSideM / 2);
  const double force_n = 0.05;
  const int steps = 20;
  world->press(Push{.object = kBox, .p_S = position() + arm, .force_n = {force_n, 0, 0}});
  run(steps * DynamicsWorld::kStepS);
  const double inertia = kBoxKg * kBoxSideM * kBoxSideM / 6.0;
  // Velocity first, then position: the sum of 1 .. n steps.
  const double expected_rad = force_n * arm.z() / inertia * DynamicsWorld::kStepS * DynamicsWorld::kStepS * steps * (steps + 1) / 2;
  EXPECT_NEAR(turn_between(Quat::Identity(), world->place(kBox).turn).y(), expected_rad, 0.01 * expected_rad);
}

// In the end the speed is v = F / b.
TEST_F(Worlds, DampingAtTheContactLimitsTheSpeed) {
  make(table_scene(), 0.0);
  world->set_gravity(Vec3::Zero());
  world->press(Push{.object = kBox, .p_S = position(), .force_n = {0.5, 0, 0}, .damping_ns_per_m = 10.0});
  run(0.3);
  const double before = position().x();
  run(0.1);
  EXPECT_NEAR((position().x() - before) / 0.1, 0.05, 1e-3);
}

TEST_F(Worlds, AnyDampingIsStable) {
  make(table_scene({.height_m = 0.1}));
  world->set_gravity(Vec3::Zero());
  const Vec3 start = position();
  for (int i = 0; i < 300; ++i) {
    world->press(Push{.object = kBox, .p_S = start, .force_n = {i % 2 == 0 ? 1.0 : -1.0, 0, 0}, .damping_ns_per_m = 1e6});
    world->step();
    ASSERT_LT((position() - start).norm(), 1e-6) << i;
  }
}

// No point of a body gets faster than the fastest surface, even if the body only turns.
TEST_F(Worlds, WhatIsTurnedGetsFasterUpToTheFastestSurface) {
  make(table_scene({.height_m = 0.1}));
  world->set_gravity(Vec3::Zero());
  world->press(Push{.object = kBox, .p_S = position(), .torque_nm = {0.0, 1e-3, 0.0}});
  run(1.0);
  const Quat before = world->place(kBox).turn;
  run(0.1);
  const double corner_m = std::sqrt(3.0) * kBoxSideM / 2;
  EXPECT_NEAR(turn_between(before, world->place(kBox).turn).norm() / 0.1, kMaxSurfaceSpeed / corner_m, 0.1);
}

// A frame stands around a post; its convex hull would not fit.
TEST_F(Worlds, ABodyThatIsNotConvexKeepsItsHole) {
  make(frame_around_post_scene());
  const Vec3 start = position();
  run(0.5);
  EXPECT_LT((position() - start).norm(), 5e-4);
  // Pushed sideways it comes to the post, and stays there.
  world->press(Push{.object = kBox, .p_S = start, .force_n = {3.0, 0, 0}, .damping_ns_per_m = 20.0});
  run(1.0);
  EXPECT_NEAR(position().x() - start.x(), kFrameGapM, 5e-4);
}

// The table is lifted: what lies on it goes along.
TEST_F(Worlds, AnObstacleCarriesWhatLiesOnIt) {
  Scene scene = table_scene();
  make_commanded(scene.objects[kTable]);
  make(scene);
  run(0.2);
  const Vec3 start = position();
  for (int i = 1; i <= 200; ++i) {
    world->move_obstacle(kTable, Pose(Eigen::Translation3d(0, 1e-4 * i, 0)));
    world->step();
  }
  run(0.2);
  EXPECT_NEAR(position().y() - start.y(), 0.02, 3e-4);
}

// A table that the stylus takes away carries nothing; where it is put down, it carries the box again, and does not throw it.
TEST_F(Worlds, AnObstacleThatIsPickedUpCarriesNothingUntilItIsPutDown) {
  Scene scene = table_scene();
  scene.objects[kTable].is_movable = true;
  make(scene);
  run(0.2);
  const Vec3 start = position();
  world->pick_up_obstacle(kTable);
  run(0.05);
  EXPECT_LT(position().y() - start.y(), -0.005) << "it falls";
  world->put_down_obstacle(kTable, Pose(Eigen::Translation3d(0.02, -0.05, 0)));
  run(1.0);
  EXPECT_NEAR(position().y() - start.y(), -0.05, 3e-4);
  EXPECT_NEAR(position().x(), start.x(), 3e-4) << "the table has gone 20 mm at once";
  // The same pose again, as it is sent once a second.
  world->put_down_obstacle(kTable, Pose(Eigen::Translation3d(0.02, -0.05, 0)));
  run(0.2);
  EXPECT_NEAR(position().y() - start.y(), -0.05, 3e-4);
}

// Bodies at rest for two seconds are not simulated any more, until something changes.
TEST_F(Worlds, ABoxThatHasComeToRestFallsWhenItsTableGoes) {
  Scene scene = table_scene();
  scene.objects[kTable].is_movable = true;
  for (const bool is_picked_up : {true, false}) {
    make(scene);
    run(3.0);
    const Vec3 start = position();
    if (is_picked_up) {
      world->pick_up_obstacle(kTable);
    } else {
      world->put_down_obstacle(kTable, Pose(Eigen::Translation3d(0, -0.05, 0)));
    }
    run(0.1);
    EXPECT_LT(position().y() - start.y(), -0.01) << is_picked_up;
  }
}

TEST_F(Worlds, ABoxThatHasComeToRestFollowsTheNewGravity) {
  run(3.0);
  const Vec3 start = position();
  world->set_gravity({kG, 0, 0});
  run(0.1);
  EXPECT_GT(position().x() - start.x(), 0.01);
}

// A box slides over the seams between triangles of a flat table without a stop.
TEST_F(Worlds, SeamsBetweenTrianglesDoNotStopABox) {
  make(table_scene({.table_cells = 20}), 0.0);
  run(0.2);
  const double height = position().y();
  world->press(Push{.object = kBox, .p_S = position(), .force_n = {0.5, 0, 0}, .damping_ns_per_m = 5.0});
  run(0.2);
  world->press(std::nullopt);
  double last = position().x();
  for (int i = 0; i < 500; ++i) {
    world->step();
    EXPECT_NEAR(position().x() - last, 1e-4, 1e-5) << i;
    EXPECT_NEAR(position().y(), height, 1.2e-4);  // Bullet's margins
    last = position().x();
  }
}

TEST_F(Worlds, WhatFallsOutOfTheSceneComesBack) {
  Scene scene = table_scene();
  SceneObject other = scene.objects[kBox];
  scene.objects[kBox].mesh = moved(*scene.objects[kBox].mesh, {0.5, 0, 0});  // beside the table
  other.mesh = moved(*other.mesh, {-0.5, 0, 0});
  make_commanded(scene.objects[kBox]);
  make_commanded(other);
  const int kOther = static_cast<int>(scene.objects.size());
  scene.objects.push_back(std::move(other));
  make(scene);
  const Vec3 start = position();
  std::vector<int> fallen;  // both in the same step: they are equally far from the middle
  for (int i = 0; i < 20'000 && fallen.empty(); ++i) {
    world->step();
    fallen.assign(world->fallen().begin(), world->fallen().end());
  }
  EXPECT_THAT(fallen, ElementsAre(kBox, kOther));
  EXPECT_LT((position() - start).norm(), 1e-6);
  world->step();
  EXPECT_TRUE(world->fallen().empty());
}

TEST_F(Worlds, WhatCannotBeABodyIsRejected) {
  Scene scene = table_scene();
  scene.objects[kBox].mass_kg = 0.0;
  EXPECT_THAT(DynamicsWorld::make(scene, kMu).error().what, HasSubstr("no object of the scene has a mass"));
  scene = table_scene();
  TriangleMesh open = *scene.objects[kBox].mesh;
  open.triangles.pop_back();
  scene.objects[kBox].mesh = std::make_shared<const TriangleMesh>(open);
  EXPECT_THAT(DynamicsWorld::make(scene, kMu).error().what, HasSubstr("object 'box' has a mass, but its surface is not closed"));
}

}  // namespace
}  // namespace hapton::dynamics
