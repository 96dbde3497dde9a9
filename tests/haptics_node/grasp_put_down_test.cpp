// What is built when an object is put down, and what happens if it cannot be put down.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/haptics_node/grasp_stage.h"
#include "tests/support/log_of.h"

namespace hapton {
namespace {

TEST_F(GraspTaskTest, WhatDoesNotMoveIsNotBuiltAgain) {
  reply(p_WD, 0);
  for (int repetition = 1; repetition <= 2; ++repetition) {
    const double x = 0.015 * (repetition - 1);
    go({x, 0.0, 0.05}, 0);
    EXPECT_EQ(go({x, 0.0, 0.021 - kPressDepth}, 0).object, kCube) << repetition;
    go(p_WD, 1);
    ASSERT_TRUE(step->holds_tool()) << repetition;
    go({x, 0.0, 0.04}, 1);
    go({x + 0.015, 0.0, 0.04}, 1);
    rest(0, 1);
    wait_for_method(2 * repetition - 1);
    go({x + 0.015, 0.0, 0.06}, 0);
    grasp->request_pose({.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = {0.015 * repetition, 0.0, 0.0}});
    rest(0, 1);
    wait_for_method(2 * repetition);
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
  reply(p_WD, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  go(p_WD, 1);
  ASSERT_TRUE(step->holds_tool());
  go({0.0, 0.0, 0.05}, 1);
  go({-0.06, 0.0, 0.05}, 1);
  const std::uint32_t held_serial = grasp->poses()[kCube].serial;
  builds_fail = true;
  const std::string log = log_of([&] {
    for (int i = 0; i < 2000 && (i < 2 || grasp->is_busy()); ++i) rest(0, 1);
  });
  EXPECT_THAT(log, testing::HasSubstr("cube cannot be put down there: no such surface; it is back where it was before it was picked up"));
  ASSERT_FALSE(grasp->is_busy());
  EXPECT_EQ(grasp->poses()[kCube].p_m, Vec3(0.0, 0.0, 0.0));
  EXPECT_FALSE(grasp->poses()[kCube].is_held);
  EXPECT_GT(grasp->poses()[kCube].serial, held_serial + 1) << "the release has a serial of its own";
  rest(0, 200);
  EXPECT_EQ(last_reply.object, -1) << "nothing is at the hand, and nothing between it and the cube holds the probe";
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-9);
  builds_fail = false;
  // The cube is felt and picked up at its old place, and put down elsewhere.
  go({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  go(p_WD, 1);
  ASSERT_TRUE(step->holds_tool());
  go({0.0, 0.0, 0.04}, 1);
  go({-0.03, 0.0, 0.04}, 1);
  rest(0, 1);
  wait_for_method(1);
  EXPECT_NEAR(grasp->poses()[kCube].p_m.x(), -0.03, 1e-4);
  rest(0, 100);
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_LT(largest_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
}

// The cube is back in its old place, and the hand is in it: the probe is on its surface, as it was when the cube was picked up.
TEST_F(GraspTaskTest, AnObjectThatIsBackUnderTheHandIsFeltFromOutside) {
  reply(p_WD, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  go(p_WD, 1);
  go({0.0, 0.0, 0.03}, 1);
  go({0.002, 0.0, 0.0205}, 1);
  builds_fail = true;
  for (int i = 0; i < 2000 && (i < 2 || grasp->is_busy()); ++i) rest(0, 1);
  ASSERT_FALSE(grasp->is_busy());
  EXPECT_EQ(grasp->poses()[kCube].p_m, Vec3(0.0, 0.0, 0.0));
  rest(0, 200);
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
  EXPECT_LT(largest_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
}

// The probe cannot follow the hand through the wall.
TEST_F(GraspTaskTest, AnObjectThatIsBackBehindAWallDoesNotHoldTheHand) {
  reply(p_WD, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  go(p_WD, 1);
  ASSERT_TRUE(step->holds_tool());
  for (const Vec3& waypoint : {Vec3(0.0, 0.0, 0.13), Vec3(0.12, 0.0, 0.13), Vec3(0.12, 0.0, 0.04)}) go(waypoint, 1);
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-6);
  builds_fail = true;
  for (int i = 0; i < 2000 && (i < 2 || grasp->is_busy()); ++i) rest(0, 1);
  ASSERT_FALSE(grasp->is_busy());
  rest(0, 200);
  EXPECT_EQ(last_reply.object, -1);
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-9);
  EXPECT_LT(largest_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
  go({0.069, 0.0, 0.04}, 0);
  EXPECT_EQ(last_reply.object, kWall) << "from this side";
  EXPECT_NEAR(last_reply.force_n.x(), 800.0 * 0.001, 1e-3);
}

TEST_F(GraspTaskTest, AMoveOnRequestThatFailsLeavesWhatIsTouched) {
  reply(p_WD, 0);
  go({-0.05, 0.0, 0.03}, 0);
  EXPECT_EQ(go({-0.05, 0.0, -kPressDepth}, 0).object, kPlate);
  builds_fail = true;
  grasp->request_pose({.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = {0.03, 0.0, 0.0}});
  rest(0, 1);
  EXPECT_TRUE(grasp->is_busy());
  for (int i = 0; i < 2000 && grasp->is_busy(); ++i) rest(0, 1);
  ASSERT_FALSE(grasp->is_busy());
  EXPECT_EQ(grasp->poses()[kCube].p_m, Vec3(0.0, 0.0, 0.0));
  rest(0, 200);
  EXPECT_EQ(last_reply.object, kPlate);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
  EXPECT_LT(largest_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
}

}  // namespace
}  // namespace hapton
