// No object leaves its place while the hub may still compute forces with the object there (Grasp::set_may_leave).
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "core/math/contact_resumption.h"
#include "tests/haptics_node/grasp_stage.h"

namespace hapton {
namespace {

struct GraspWithdrawalTest : GraspTaskTest {
  GraspWithdrawalTest() {
    reply(p_WD, 0);
    EXPECT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  }
  // Builds the scene with the object that was put down; no sample comes meanwhile.
  void build_without_samples() {
    for (int n = 0; n < 30'000 && method_changes == 0; ++n) {
      task->run_once();
      take_method();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_EQ(method_changes, 1);
  }
  // The first sample after the hub has computed the force, with its probe at p_WP.
  void resume_at(const Vec3& p_WP, std::uint32_t buttons) {
    ++sample;
    step->offer({.sample = sample,
                 .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000,
                 .p_WD = p_WD,
                 .buttons = buttons,
                 .is_resumed = true,
                 .p_WP = p_WP});
    last_reply = step->reply();
    task->run_once();
    take_method();
  }
  // Picks the object up and puts it down; the hand then rests on it, where it was before.
  void hold_and_put_down() {
    rest(1, 200);
    ASSERT_TRUE(step->holds_tool());
    rest(0, 1);
    wait_for_method(1);
    rest(0, 200);
    ASSERT_EQ(last_reply.object, kCube);
  }
  void press_on_plate() {
    go({0.0, 0.0, 0.05}, 0);
    go({-0.08, 0.0, 0.05}, 0);
    EXPECT_EQ(go({-0.08, 0.0, -kPressDepth}, 0).object, 0);
  }
};

TEST_F(GraspWithdrawalTest, WhatIsPickedUpWaitsAndIsFeltWhereItLies) {
  EXPECT_FALSE(grasp->is_object_away(true));
  grasp->set_may_leave(false);
  reply(p_WD, 1);
  EXPECT_TRUE(grasp->is_object_away(true)) << "its tool has been requested";
  rest(1, 200);
  EXPECT_TRUE(grasp->is_object_away(false)) << "its tool is made";
  EXPECT_FALSE(step->holds_tool());
  EXPECT_FALSE(grasp->poses()[kCube].is_held);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
  EXPECT_EQ(last_reply.object, kCube);
  grasp->set_may_leave(true);
  reply(p_WD, 1);
  EXPECT_TRUE(step->holds_tool());
  EXPECT_TRUE(grasp->poses()[kCube].is_held);
  EXPECT_TRUE(grasp->is_object_away(false));
  rest(1, 200);
  EXPECT_LT(largest_change_n, 800.0 * 1e-4 + 0.02);
  delays_methods = true;
  rest(0, 100);
  EXPECT_TRUE(grasp->is_object_away(false)) << "it is not felt yet where it was put down";
  delays_methods = false;
  wait_for_method(1);
  EXPECT_FALSE(grasp->is_object_away(true));
}

TEST_F(GraspWithdrawalTest, AButtonReleasedBeforeTheObjectMayLeaveMovesNothing) {
  const std::uint32_t serial = grasp->poses()[kCube].serial;
  grasp->set_may_leave(false);
  rest(1, 200);
  rest(0, 5);
  EXPECT_FALSE(grasp->is_object_away(true));
  grasp->set_may_leave(true);
  rest(0, 100);
  EXPECT_FALSE(step->holds_tool());
  EXPECT_EQ(grasp->poses()[kCube].serial, serial);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
  // The next press picks the cube up.
  rest(1, 200);
  EXPECT_TRUE(step->holds_tool());
}

TEST_F(GraspWithdrawalTest, AMoveOnRequestWaits) {
  go({0.0, 0.0, 0.05}, 0);
  const ObjectPose pose = {.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = Vec3(0.03, 0.0, 0.0)};
  grasp->set_may_leave(false);
  EXPECT_FALSE(grasp->is_object_away(true));
  grasp->request_pose(pose);
  EXPECT_TRUE(grasp->is_object_away(false));
  rest(0, 100);
  EXPECT_EQ(grasp->poses()[kCube].p_m, Vec3(Vec3::Zero()));
  EXPECT_TRUE(grasp->is_object_away(false)) << "without being repeated";
  EXPECT_FALSE(grasp->is_busy());
  grasp->set_may_leave(true);
  rest(0, 1);
  EXPECT_EQ(grasp->poses()[kCube].p_m, pose.p_m);
  wait_for_method(1);
  EXPECT_EQ(go({0.03, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  grasp->set_may_leave(false);
  grasp->request_pose(pose);
  EXPECT_FALSE(grasp->is_object_away(true)) << "that pose is not the newest any more";
}

// Once the hub has no parts any more, it asks to continue from its probe. An object that waited must not leave before that is known.
TEST_F(GraspWithdrawalTest, WhatLeavesAsTheProbeBeginsAnewTakesNoContactAway) {
  press_on_plate();
  grasp->set_may_leave(false);
  grasp->request_pose({.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = Vec3(0.03, 0.0, 0.0)});
  reply(p_WD, 0);
  grasp->set_may_leave(true);
  resume_at({-0.08, 0.0, 0.0}, 0);
  EXPECT_TRUE(last_reply.contact);
  rest(0, 1);
  EXPECT_NEAR(grasp->poses()[kCube].p_m.x(), 0.03, 0.0);
  wait_for_method(1);
  rest(0, 200);
  EXPECT_EQ(last_reply.object, 0) << "the hand stays on the plate";
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
}

TEST_F(GraspWithdrawalTest, AButtonPressedAsTheProbeBeginsAnewCounts) {
  resume_at({0.0, 0.0, 0.021}, 1);
  rest(1, 200);
  EXPECT_TRUE(step->holds_tool());
  rest(0, 5);
  wait_for_method(1);
  // In a new session, a short press and its release leave nothing held; the next press picks the object up.
  step->restart();
  resume_at({0.0, 0.0, 0.021}, 0);
  rest(1, 5);
  rest(0, 5);
  EXPECT_FALSE(step->holds_tool());
  rest(1, 200);
  EXPECT_TRUE(step->holds_tool()) << "released and pressed again";
}

TEST_F(GraspWithdrawalTest, AButtonHeldSinceBeforeTheProbeBeginsAnewPicksNothingUp) {
  const Vec3 p_pressed = p_WD;
  go({0.0, 0.0, 0.05}, 0);
  rest(1, 5);
  ASSERT_EQ(go(p_pressed, 1).object, kCube) << "pressed in free space";
  resume_at({0.0, 0.0, 0.021}, 1);
  rest(1, 200);
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_FALSE(step->holds_tool());
  rest(0, 5);
  rest(1, 200);
  EXPECT_TRUE(step->holds_tool()) << "released and pressed again";
}

// A new session of the hub begins. The scene with the object put down is ready before the first sample of that session has a reply.
TEST_F(GraspWithdrawalTest, APutDownBeforeTheFirstSampleOfASessionKeepsTheContact) {
  rest(1, 200);
  ASSERT_TRUE(step->holds_tool());
  delays_methods = true;
  rest(0, 10);
  step->resume();
  delays_methods = false;
  ASSERT_NO_FATAL_FAILURE(build_without_samples());
  rest(0, 200);
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
}

// The hub restarts before any sample has a reply in the scene with the object put down.
TEST_F(GraspWithdrawalTest, ASessionThatBeginsAfterAPutDownKeepsTheContact) {
  rest(1, 200);
  ASSERT_TRUE(step->holds_tool());
  rest(0, 1);
  ASSERT_NO_FATAL_FAILURE(build_without_samples());
  step->resume();
  rest(0, 200);
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
}

// The hub may not have got a reply since the object was put down: its position is then that of a hand without a probe.
TEST_F(GraspWithdrawalTest, WhatTheHubKnowsFromBeforeAPutDownTakesNoContactAway) {
  const Vec3 before = p_WD;
  ASSERT_NO_FATAL_FAILURE(hold_and_put_down());
  sample += 199;  // the longest gap after which this node's own contact counts: 200 ms
  resume_at(before - Vec3(0.0, 0.0, 1e-5), 0);
  rest(0, 200);
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
}

// After a long time without samples, the hand may have gone around what it touched in this node: then the hub's position counts.
TEST_F(GraspWithdrawalTest, WhatWasFeltHereLongAgoDoesNotCount) {
  const Vec3 before = p_WD;
  ASSERT_NO_FATAL_FAILURE(hold_and_put_down());
  sample += 200;
  resume_at(before - Vec3(0.0, 0.0, 1e-5), 0);
  rest(0, 200);
  EXPECT_EQ(last_reply.object, -1);
  EXPECT_EQ(last_reply.force_n.norm(), 0.0);
}

TEST_F(GraspWithdrawalTest, ARequestIsWithdrawnWhereTheButtonIsUpAsTheProbeBeginsAnew) {
  grasp->set_may_leave(false);
  rest(1, 5);
  step->restart();
  reply(p_WD, 1);
  EXPECT_TRUE(grasp->is_busy());
  step->restart();
  reply(p_WD, 0);
  EXPECT_FALSE(grasp->is_busy());
}

// Otherwise the object would follow the hand, through whatever is in between.
TEST_F(GraspWithdrawalTest, AHandThatHasGonePicksNothingUp) {
  const Vec3 start = p_WD;
  for (const bool may_leave : {false, true}) {
    SCOPED_TRACE(may_leave);
    const std::uint32_t serial = grasp->poses()[kCube].serial;
    grasp->set_may_leave(may_leave);
    for (const double distance_m : {0.9 * kResumeReachM, 1.1 * kResumeReachM}) {
      SCOPED_TRACE(distance_m);
      const Vec3 p_pressed = start + grasp->poses()[kCube].p_m;
      // The button is pressed before the tool is made, whether the hub has parts or not.
      const auto sample_at = [&](const Vec3& p, std::uint32_t buttons) {
        step->offer({.sample = ++sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p, .buttons = buttons});
        last_reply = step->reply();
      };
      sample_at(p_pressed, 1);
      for (int n = 1; n <= 400; ++n) sample_at(p_pressed + Vec3(0.0, 0.0, distance_m * n / 400), 1);
      p_WD = p_pressed + Vec3(0.0, 0.0, distance_m);
      grasp->set_may_leave(true);
      for (int n = 0; n < 200; ++n) reply(p_WD, 1);
      EXPECT_EQ(step->holds_tool(), distance_m < kResumeReachM);
      if (distance_m < kResumeReachM) {
        const int changes_before = method_changes;
        rest(0, 5);
        wait_for_method(changes_before + 1);
        go(start + grasp->poses()[kCube].p_m, 0);
        ASSERT_EQ(last_reply.object, kCube);
      } else {
        EXPECT_FALSE(grasp->is_busy());
        EXPECT_FALSE(grasp->is_object_away(true)) << "the parts may be sent again";
        rest(0, 5);
        go(p_pressed, 0);
      }
    }
    EXPECT_GT(grasp->poses()[kCube].serial, serial);
  }
}

TEST_F(GraspWithdrawalTest, AHandThatHasTurnedPicksNothingUp) {
  grasp->set_may_leave(false);
  for (int n = 0; n <= 400; ++n) reply(p_WD, 1, turn_by({0.0, 0.0, 1.1 * kResumeTurnRad * n / 400}));
  EXPECT_FALSE(grasp->is_busy());
  grasp->set_may_leave(true);
  for (int n = 0; n < 50; ++n) reply(p_WD, 1, turn_by({0.0, 0.0, 1.1 * kResumeTurnRad}));
  EXPECT_FALSE(step->holds_tool());
}

// The hand goes 14 mm down before the slow task has found the pose of the tool, which then rests on the plate. Either the object is already
// picked up, or it still waits and the hand feels the probe.
TEST_F(GraspWithdrawalTest, TheFirstForceOfWhatIsPickedUpLateMakesNoJump) {
  const auto press_without_task = [&](const Vec3& p) {
    step->offer({.sample = ++sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p, .buttons = 1});
    last_reply = step->reply();
    p_WD = p;
  };
  const Vec3 p_pressed = p_WD;
  for (const bool is_picked_up_before : {true, false}) {
    SCOPED_TRACE(is_picked_up_before);
    grasp->set_may_leave(is_picked_up_before);
    press_without_task(p_pressed);
    for (int n = 0; n < 5; ++n) task->run_once();
    for (int n = 1; n <= 400; ++n) press_without_task(p_pressed - Vec3(0.0, 0.0, 0.014 * n / 400));
    ASSERT_EQ(step->holds_tool(), is_picked_up_before);
    ASSERT_EQ(last_reply.force_n.isZero(0.0), is_picked_up_before);
    grasp->set_may_leave(true);
    largest_change_n = 0.0;
    rest(1, 300);
    ASSERT_TRUE(step->holds_tool());
    EXPECT_GT(last_reply.force_n.z(), 8.0);
    EXPECT_LT(largest_change_n, 0.12 * last_reply.force_n.z()) << "a sample without a tool is one in free space";
    const int changes_before = method_changes;
    go(p_pressed, 1);
    rest(0, 5);
    wait_for_method(changes_before + 1);
    go(p_pressed, 0);
  }
}

// This must not need another sample: while the hub computes the force, samples are rare.
TEST_F(GraspWithdrawalTest, AToolThatIsMadeIsKnownBetweenSamples) {
  grasp->set_may_leave(false);
  step->offer({.sample = ++sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p_WD, .buttons = 1});
  step->reply();
  EXPECT_FALSE(grasp->is_object_away(false));
  for (int n = 0; n < 5; ++n) task->run_once();
  EXPECT_TRUE(grasp->is_object_away(false));
}

}  // namespace
}  // namespace hapton
