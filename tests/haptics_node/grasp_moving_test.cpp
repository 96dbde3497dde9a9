// Objects that move by themselves, beside one that is picked up.
#include <gtest/gtest.h>

#include "scene/object_reader.h"
#include "tests/haptics_node/grasp_stage.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kWallStartS = 3.0;          // until then the wall stands still
constexpr double kWallTravelM = 0.02;        // how far the wall moves, towards the cube
constexpr double kStiffness = 800.0;         // of all surfaces
constexpr double kMaxJumpN = 0.03;           // the wall moves about 20 um in a sample: with the hand at rest, the force changes by 0.016 N
const Vec3 kLiftedHand = {0.03, 0.0, 0.04};  // position of the stylus with the cube: the cube's face is 10 mm from the wall at rest

void let_wall_move(Scene& scene) {
  const Keyframe rest{kWallStartS, Vec3::Zero(), Quat::Identity()};
  const Keyframe there{kWallStartS + 1.0, {-kWallTravelM, 0.0, 0.0}, Quat::Identity()};
  scene.objects[2].motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, rest, there}, false);
}

void let_programs_move_wall(Scene& scene) {
  ObjectSpec spec;
  spec.motion.by_program = true;
  scene.objects[2].commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *scene.objects[2].mesh);
}

struct GraspBesideKeyframes : GraspTaskTest {
  GraspBesideKeyframes() : GraspTaskTest({}, {}, let_wall_move) {}
  void lift_cube() {
    reply(p_WD, 0);
    go({0.0, 0.0, 0.021 - kPressDepth}, 0);
    go(p_WD, 1);
    ASSERT_TRUE(step->holds_tool());
    go({0.0, 0.0, 0.04}, 1);
    go(kLiftedHand, 1);
    ASSERT_LT(1e-9 * static_cast<double>(step->scene_time_ns()), kWallStartS);
    EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-6);
  }
  void wait_until_s(double time_s, std::uint32_t buttons) {
    while (1e-9 * static_cast<double>(step->scene_time_ns()) < time_s) rest(buttons, 1);
  }
};

TEST_F(GraspBesideKeyframes, WhatIsHeldIsPushedByWhatMovesAndPutDownBesideIt) {
  ASSERT_NO_FATAL_FAILURE(lift_cube());
  largest_change_n = 0.0;
  wait_until_s(kWallStartS + 1.5, 1);
  // The wall has gone 10 mm beyond the face of the cube.
  EXPECT_NEAR(last_reply.force_n.x(), -kStiffness * 0.01, 0.02);
  EXPECT_NEAR(last_reply.visual_offset_m.x(), -0.01, 2e-5);
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_FALSE(last_reply.push) << "no program moves it";
  EXPECT_LT(largest_change_n, kMaxJumpN);

  // The cube goes onto the plate, where the wall leaves room for it.
  go({-0.02, 0.0, 0.04}, 1);
  go({-0.02, 0.0, 0.0195}, 1);
  rest(0, 1);
  EXPECT_FALSE(step->holds_tool());
  wait_for_method(1);
  rest(0, 200);
  EXPECT_EQ(last_reply.object, kCube) << "the stylus still presses where it released the object";
  EXPECT_NEAR(grasp->poses()[kCube].p_m.x(), -0.02, 1e-4);

  // The new method has the wall where it is now.
  go({-0.02, 0.0, 0.05}, 0);
  go({0.02, 0.0, 0.05}, 0);
  EXPECT_EQ(last_reply.object, -1);
  go({0.03 + kPressDepth, 0.0, 0.05}, 0);
  EXPECT_EQ(last_reply.object, kWall);
  EXPECT_NEAR(last_reply.force_n.x(), -kStiffness * kPressDepth, 1e-3);
  EXPECT_LT(largest_change_n, kStiffness * 1e-4 + 0.02);
}

TEST_F(GraspBesideKeyframes, ACubeThatIsPutDownIsPickedUpAgainBesideTheWallWhereThatIsNow) {
  ASSERT_NO_FATAL_FAILURE(lift_cube());
  rest(0, 1);
  wait_for_method(1);
  rest(0, 200);
  wait_until_s(kWallStartS + 1.5, 0);
  // By now the wall has moved through the cube, which lies where it was released.
  EXPECT_EQ(last_reply.object, kCube);
  go({0.024, 0.0, 0.06}, 0);
  go({0.024, 0.0, 0.0405 - 2.0 * kPressDepth}, 0);
  ASSERT_EQ(last_reply.object, kCube);
  go(p_WD, 1);
  ASSERT_TRUE(step->holds_tool());
  EXPECT_TRUE(step->is_tool_blocked()) << "it overlaps the wall";
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-6);
  go({0.004, 0.0, p_WD.z()}, 1);
  EXPECT_FALSE(step->is_tool_blocked());
  // The stylus holds the cube 4 mm from its face towards the wall, which is at 0.03 now.
  go({0.016, 0.0, p_WD.z()}, 1);
  EXPECT_NEAR(last_reply.force_n.x(), -kStiffness * 0.002, 0.02);
}

TEST_F(GraspBesideKeyframes, TheStepUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  ASSERT_NO_FATAL_FAILURE(lift_cube());
  for (int n = 0; n < 1'500; ++n) {
    step->offer({.sample = ++sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p_WD, .buttons = 1});
    const AllocationGuard guard;
    last_reply = step->reply();
    ASSERT_EQ(guard.count(), 0U) << n;
    if (n % 3 == 0) task->run_once();
  }
  EXPECT_LT(last_reply.force_n.x(), -1.0) << "the wall has come";
}

struct GraspBesidePrograms : GraspTaskTest {
  GraspBesidePrograms() : GraspTaskTest({}, {}, let_programs_move_wall) {}
};

// The held object pushes the wall, with the opposite of the force that the hand feels.
TEST_F(GraspBesidePrograms, WhatIsHeldPushesWhatProgramsMove) {
  reply(p_WD, 0);
  EXPECT_FALSE(last_reply.push) << "nothing is held";
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  go(p_WD, 1);
  ASSERT_TRUE(step->holds_tool());
  ASSERT_TRUE(last_reply.push);
  EXPECT_EQ(last_reply.push->force_n, Vec3(Vec3::Zero()));
  EXPECT_EQ(last_reply.object, kCube);
  go({0.0, 0.0, 0.04}, 1);
  go({0.041, 0.0, 0.04}, 1);
  EXPECT_EQ(last_reply.object, kWall);
  ASSERT_TRUE(last_reply.push);
  EXPECT_NEAR(last_reply.force_n.x(), -kStiffness * 0.001, 0.01);
  EXPECT_TRUE(last_reply.push->force_n.isApprox(-last_reply.force_n, 1e-9));

  // A program moves the wall away, beyond the cube's reach.
  const Vec3 pivot = scene.objects[kWall].commanded->pivot();
  const double now_s = 1e-9 * static_cast<double>(step->scene_time_ns());
  ASSERT_TRUE(step->command(kWall, {.serial = 1,
                                    .from = {now_s + 0.002, pivot, Quat::Identity()},
                                    .to = {now_s + 0.2, pivot + Vec3(0.01, 0.0, 0.0), Quat::Identity()}}));
  largest_change_n = 0.0;
  rest(1, 400);
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-6);
  EXPECT_LT(largest_change_n, kMaxJumpN + kStiffness * 1e-4);

  // The cube is put down, and the wall is felt where the program has moved it.
  go({0.0, 0.0, 0.0195}, 1);
  rest(0, 1);
  wait_for_method(1);
  go({0.0, 0.0, 0.06}, 0);
  go({0.06 + kPressDepth, 0.0, 0.06}, 0);
  EXPECT_EQ(last_reply.object, kWall);
  EXPECT_NEAR(last_reply.force_n.x(), -kStiffness * kPressDepth, 1e-3);
}

}  // namespace
}  // namespace hapton
