// Nothing leaves its place while somebody else computes forces with it there (Grasp::set_free).
#include <gtest/gtest.h>

#include "tests/haptics_node/grasp_stage.h"

namespace hapton {
namespace {

struct GraspWithdrawalTest : GraspTaskTest {
  GraspWithdrawalTest() {
    reply(at, 0);
    EXPECT_EQ(go({0.0, 0.0, 0.021 - kPress}, 0).object, kCube);
  }
};

TEST_F(GraspWithdrawalTest, WhatIsPickedUpWaitsAndIsFeltWhereItLies) {
  EXPECT_FALSE(grasp->is_leaving(true));
  grasp->set_free(false);
  reply(at, 1);
  EXPECT_TRUE(grasp->is_leaving(true)) << "it has been requested";
  rest(1, 200);
  EXPECT_TRUE(grasp->is_leaving(false)) << "its tool is made";
  EXPECT_FALSE(step->holds_tool());
  EXPECT_FALSE(grasp->poses()[kCube].is_held);
  EXPECT_NEAR(last.force_n.z(), 800.0 * kPress, 1e-3);
  EXPECT_EQ(last.object, kCube);
  grasp->set_free(true);
  reply(at, 1);
  EXPECT_TRUE(step->holds_tool());
  EXPECT_TRUE(grasp->poses()[kCube].is_held);
  EXPECT_TRUE(grasp->is_leaving(false));
  rest(1, 200);
  EXPECT_LT(most_change_n, 800.0 * 1e-4 + 0.02);
  waits = true;
  rest(0, 100);
  EXPECT_TRUE(grasp->is_leaving(false)) << "it is not felt yet where it was put down";
  waits = false;
  wait_for_method(1);
  EXPECT_FALSE(grasp->is_leaving(true));
}

TEST_F(GraspWithdrawalTest, WhoReleasesTheButtonMeanwhileMovesNothing) {
  const std::uint32_t serial = grasp->poses()[kCube].serial;
  grasp->set_free(false);
  rest(1, 200);
  rest(0, 5);
  EXPECT_FALSE(grasp->is_leaving(true));
  grasp->set_free(true);
  rest(0, 100);
  EXPECT_FALSE(step->holds_tool());
  EXPECT_EQ(grasp->poses()[kCube].serial, serial);
  EXPECT_NEAR(last.force_n.z(), 800.0 * kPress, 1e-3);
  // And the next time it is picked up.
  rest(1, 200);
  EXPECT_TRUE(step->holds_tool());
}

TEST_F(GraspWithdrawalTest, WhatIsRequestedElsewhereWaits) {
  go({0.0, 0.0, 0.05}, 0);
  const ObjectPose pose = {.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = Vec3(0.03, 0.0, 0.0)};
  grasp->set_free(false);
  EXPECT_FALSE(grasp->is_leaving(true));
  grasp->request(pose);
  EXPECT_TRUE(grasp->is_leaving(false));
  rest(0, 100);
  EXPECT_EQ(grasp->poses()[kCube].p_m, Vec3(Vec3::Zero()));
  EXPECT_TRUE(grasp->is_leaving(false)) << "without being repeated";
  EXPECT_FALSE(grasp->is_busy());
  grasp->set_free(true);
  rest(0, 1);
  EXPECT_EQ(grasp->poses()[kCube].p_m, pose.p_m);
  wait_for_method(1);
  EXPECT_EQ(go({0.03, 0.0, 0.021 - kPress}, 0).object, kCube);
  grasp->set_free(false);
  grasp->request(pose);
  EXPECT_FALSE(grasp->is_leaving(true)) << "that pose is not the newest any more";
}

}  // namespace
}  // namespace hapton
