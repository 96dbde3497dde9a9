// What is built when an object is put down, and what happens if it cannot be put down.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/haptics_node/grasp_stage.h"
#include "tests/support/log_of.h"

namespace hapton {
namespace {

TEST_F(GraspTaskTest, WhatDoesNotMoveIsNotBuiltAgain) {
  reply(at, 0);
  for (int turn = 1; turn <= 2; ++turn) {
    const double x = 0.015 * (turn - 1);
    go({x, 0.0, 0.05}, 0);
    EXPECT_EQ(go({x, 0.0, 0.021 - kPress}, 0).object, kCube) << turn;
    go(at, 1);
    ASSERT_TRUE(step->holds_tool()) << turn;
    go({x, 0.0, 0.04}, 1);
    go({x + 0.015, 0.0, 0.04}, 1);
    rest(0, 1);
    wait_for_method(2 * turn - 1);
    go({x + 0.015, 0.0, 0.06}, 0);
    grasp->request_pose({.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = {0.015 * turn, 0.0, 0.0}});
    rest(0, 1);
    wait_for_method(2 * turn);
  }
  ASSERT_EQ(built_of.size(), 4U);
  for (std::size_t n = 0; n < 4; ++n) {
    ASSERT_NE(built_of[n], nullptr) << n;
    for (const int object : {kPlate, kWall}) {
      EXPECT_EQ(built_of[n]->objects[object], built_of[0]->objects[object]) << n;
      EXPECT_EQ(built_of[n]->meshes[object], scene.objects[object].mesh);
    }
    EXPECT_EQ(built_of[n]->frame.origin, built_of[0]->frame.origin);
  }
  EXPECT_NE(built_of[1]->objects[kCube], built_of[0]->objects[kCube]);
}

// The object is drawn where it is felt.
TEST_F(GraspTaskTest, AnObjectThatCannotBePutDownIsBackWhereItWas) {
  reply(at, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPress}, 0).object, kCube);
  go(at, 1);
  ASSERT_TRUE(step->holds_tool());
  go({0.0, 0.0, 0.05}, 1);
  go({-0.06, 0.0, 0.05}, 1);
  const std::uint32_t held = grasp->poses()[kCube].serial;
  fails = true;
  const std::string log = log_of([&] {
    for (int i = 0; i < 2000 && (i < 2 || grasp->is_busy()); ++i) rest(0, 1);
  });
  EXPECT_THAT(log, testing::HasSubstr("cube cannot be put down there: no such surface; it is back where it was before it was picked up"));
  ASSERT_FALSE(grasp->is_busy());
  EXPECT_EQ(grasp->poses()[kCube].p_m, Vec3(0.0, 0.0, 0.0));
  EXPECT_FALSE(grasp->poses()[kCube].is_held);
  EXPECT_GT(grasp->poses()[kCube].serial, held + 1) << "the release is known by its own";
  rest(0, 200);
  EXPECT_EQ(last.object, -1) << "nothing is at the hand, and nothing between it and the cube holds the probe";
  EXPECT_NEAR(last.force_n.norm(), 0.0, 1e-9);
  fails = false;
  // The cube is felt and picked up at its old place, and put down elsewhere.
  go({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPress}, 0).object, kCube);
  go(at, 1);
  ASSERT_TRUE(step->holds_tool());
  go({0.0, 0.0, 0.04}, 1);
  go({-0.03, 0.0, 0.04}, 1);
  rest(0, 1);
  wait_for_method(1);
  EXPECT_NEAR(grasp->poses()[kCube].p_m.x(), -0.03, 1e-4);
  rest(0, 100);
  EXPECT_EQ(last.object, kCube);
  EXPECT_LT(most_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
}

// The cube is back in its old place, and the hand is in it: the probe is on its surface, as it was when the cube was picked up.
TEST_F(GraspTaskTest, AnObjectThatIsBackUnderTheHandIsFeltFromOutside) {
  reply(at, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPress}, 0).object, kCube);
  go(at, 1);
  go({0.0, 0.0, 0.03}, 1);
  go({0.002, 0.0, 0.0205}, 1);
  fails = true;
  for (int i = 0; i < 2000 && (i < 2 || grasp->is_busy()); ++i) rest(0, 1);
  ASSERT_FALSE(grasp->is_busy());
  EXPECT_EQ(grasp->poses()[kCube].p_m, Vec3(0.0, 0.0, 0.0));
  rest(0, 200);
  EXPECT_EQ(last.object, kCube);
  EXPECT_NEAR(last.force_n.z(), 800.0 * kPress, 1e-3);
  EXPECT_LT(most_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
}

// The probe cannot follow the hand through the wall.
TEST_F(GraspTaskTest, AnObjectThatIsBackBehindAWallDoesNotHoldTheHand) {
  reply(at, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPress}, 0).object, kCube);
  go(at, 1);
  ASSERT_TRUE(step->holds_tool());
  for (const Vec3& by : {Vec3(0.0, 0.0, 0.13), Vec3(0.12, 0.0, 0.13), Vec3(0.12, 0.0, 0.04)}) go(by, 1);
  EXPECT_NEAR(last.force_n.norm(), 0.0, 1e-6);
  fails = true;
  for (int i = 0; i < 2000 && (i < 2 || grasp->is_busy()); ++i) rest(0, 1);
  ASSERT_FALSE(grasp->is_busy());
  rest(0, 200);
  EXPECT_EQ(last.object, -1);
  EXPECT_NEAR(last.force_n.norm(), 0.0, 1e-9);
  EXPECT_LT(most_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
  go({0.069, 0.0, 0.04}, 0);
  EXPECT_EQ(last.object, kWall) << "from this side";
  EXPECT_NEAR(last.force_n.x(), 800.0 * 0.001, 1e-3);
}

TEST_F(GraspTaskTest, AMoveOnRequestThatFailsLeavesWhatIsTouched) {
  reply(at, 0);
  go({-0.05, 0.0, 0.03}, 0);
  EXPECT_EQ(go({-0.05, 0.0, -kPress}, 0).object, kPlate);
  fails = true;
  grasp->request_pose({.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = {0.03, 0.0, 0.0}});
  rest(0, 1);
  EXPECT_TRUE(grasp->is_busy());
  for (int i = 0; i < 2000 && grasp->is_busy(); ++i) rest(0, 1);
  ASSERT_FALSE(grasp->is_busy());
  EXPECT_EQ(grasp->poses()[kCube].p_m, Vec3(0.0, 0.0, 0.0));
  rest(0, 200);
  EXPECT_EQ(last.object, kPlate);
  EXPECT_NEAR(last.force_n.z(), 800.0 * kPress, 1e-3);
  EXPECT_LT(most_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
}

}  // namespace
}  // namespace hapton
