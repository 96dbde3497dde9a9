#include "haptics_node/grasp_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "core/math/rotation_vector.h"
#include "haptic_step/haptics_setup.h"
#include "haptic_step/scene_facts.h"
#include "scene/scene_hash.h"
#include "tests/haptics_node/grasp_stage.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/log_of.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(GraspTaskTest, EachObjectHasANumberAndAMovableOneAPoseFromTheStart) {
  const Grasp other(link, {true, false, true}, 1U);
  ASSERT_EQ(other.poses().size(), 3U);
  for (std::size_t o = 0; o < 3; ++o) {
    EXPECT_EQ(other.poses()[o].object, static_cast<std::int32_t>(o));
    EXPECT_EQ(other.poses()[o].serial, o == 1 ? 0U : 1U);
  }
}

TEST_F(GraspTaskTest, AMovableObjectIsPickedUpPushedAgainstAnotherAndPutDown) {
  reply(p_WD, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
  go(p_WD, 1);
  EXPECT_TRUE(step->holds_tool());
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-6) << "it weighs nothing";

  go({0.0, 0.0, 0.04}, 1);
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-6);
  go({0.041, 0.0, 0.04}, 1);
  // The face of the cube, 0.01 ahead of the stylus, is stopped at the face of the wall, at 0.05.
  EXPECT_NEAR(last_reply.force_n.x(), -800.0 * 0.001, 0.01);
  EXPECT_NEAR(last_reply.visual_offset_m.x(), -0.001, 1e-5);
  go({0.03, 0.0, 0.04}, 1);
  // The cube goes down onto the plate: the stylus is 0.0205 - 0.001 above the cube's bottom.
  go({0.03, 0.0, 0.0195 + 0.0005}, 1);
  go({0.03, 0.0, 0.0195}, 1);
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 0.01);
  const double held_z_m = p_WD.z() + last_reply.visual_offset_m.z();

  rest(0, 1);
  EXPECT_FALSE(step->holds_tool());
  wait_for_method(1);
  rest(0, 200);
  EXPECT_EQ(last_reply.object, kCube) << "the stylus still presses where it released the object";
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 0.05);
  EXPECT_NEAR(held_z_m, p_WD.z(), 1e-4);

  ASSERT_EQ(grasp->poses().size(), 3U);
  const ObjectPose& pose = grasp->poses()[kCube];
  EXPECT_FALSE(pose.is_held);
  EXPECT_EQ(pose.serial, 3U);
  EXPECT_NEAR(pose.p_m.x(), 0.03, 1e-4);
  EXPECT_NEAR(pose.p_m.z(), -0.001, 1e-4);
  EXPECT_EQ(grasp->poses()[kPlate].serial, 0U);
  const PlacedScene* placed = wait_for_placed();
  ASSERT_NE(placed, nullptr);
  EXPECT_EQ(placed->revision, 1U);
  Scene moved = scene;
  move_object(PutDown{kCube, pose.p_m, pose.q}.pose(), scene.objects[kCube], moved.objects[kCube]);
  EXPECT_EQ(placed->facts.point_count, make_scene_facts(moved).point_count);
  EXPECT_EQ(placed->facts.highest_m[0], make_scene_facts(moved).highest_m[0]);
  EXPECT_NE(placed->hash, hash_scene(scene.touch_scene()));
  EXPECT_EQ(grasp->take_placed(), nullptr);

  go({0.03, 0.0, 0.05}, 0);
  go({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.0 - kPressDepth}, 0).object, kPlate) << "nothing is left where it was";
  EXPECT_LT(largest_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
  EXPECT_LT(largest_change_nm, 0.01);
}

// A vision node that draws the object moves it with the stylus.
TEST_F(GraspTaskTest, AHeldObjectIsShownInTheFrameOfTheStylus) {
  reply(p_WD, 0);
  const Vec3 moved(0.03, 0.0, 0.0);
  grasp->request_pose({.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = moved});
  rest(0, 1);
  wait_for_method(1);
  go({0.03, 0.0, 0.05}, 0);
  ASSERT_EQ(go({0.03, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  for (int n = 1; n <= 100; ++n) reply(p_WD, 0, turn_by({0.002 * n, 0.0, 0.0}));
  const Quat turned = turn_by({0.2, 0.0, 0.0});
  for (int n = 0; n < 50; ++n) reply(p_WD, 1, turned);
  ASSERT_TRUE(step->holds_tool());
  const ObjectPose& pose = grasp->poses()[kCube];
  EXPECT_TRUE(pose.is_held);
  EXPECT_LT((p_WD + turned * pose.p_m - moved).norm(), 1e-9) << "it has not moved yet";
  EXPECT_LT((turned * pose.q).angularDistance(Quat::Identity()), 1e-6);
}

// The touched surfaces damp a held object, with the damping that `hapton set` has given them since the scene was loaded.
TEST_F(GraspTaskTest, WhatIsHeldFeelsDampingAsItWasTunedBefore) {
  MaterialRequest request{.request = 1, .change = {.fields = MaterialChange::kDamping, .damping_ns_per_m = 3.0}};
  put_text("wall", request.object);
  material_task->request(request);
  for (int i = 0; i < 3000 && material_task->take() == nullptr; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_TRUE(material_task->accepted());
  reply(p_WD, 0);
  ASSERT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  go(p_WD, 1);
  ASSERT_TRUE(step->holds_tool());
  go({0.0, 0.0, 0.04}, 1);
  go({0.0403, 0.0, 0.04}, 1);
  EXPECT_NEAR(last_reply.force_n.x(), -800.0 * 0.0003, 1e-3) << "at rest";
  for (int n = 1; n <= 10; ++n) reply({0.0403 + 5e-5 * n, 0.0, 0.04}, 1);
  EXPECT_NEAR(last_reply.force_n.x(), -800.0 * 0.0008 - 3.0 * 0.05, 1e-3);
  go({0.03, 0.0, 0.04}, 1);
  rest(0, 1);
  wait_for_method(1);
  EXPECT_TRUE(material_task->accepted());
  ASSERT_FALSE(felt_scenes.empty());
  EXPECT_EQ(felt_scenes.back().objects[kWall].material.damping_ns_per_m, 3.0) << "as it is felt";
}

TEST_F(GraspTaskTest, WhatHasMovedIsPickedUpAgain) {
  reply(p_WD, 0);
  for (int repetition = 1; repetition <= 3; ++repetition) {
    const double x = 0.01 * (repetition - 1);
    go({x, 0.0, 0.05}, 0);
    EXPECT_EQ(go({x, 0.0, 0.021 - kPressDepth}, 0).object, kCube) << repetition;
    go(p_WD, 1);
    ASSERT_TRUE(step->holds_tool()) << repetition;
    go({x, 0.0, 0.04}, 1);
    go({x + 0.01, 0.0, 0.04}, 1);
    go({x + 0.01, 0.0, 0.021 - kPressDepth}, 1);
    rest(0, 1);
    wait_for_method(repetition);
    EXPECT_NEAR(grasp->poses()[kCube].p_m.x(), 0.01 * repetition, 1e-4);
  }
}

// The cube lies 30 mm aside, after a quarter turn, as a file of annotations may say.
struct PlacedGraspTest : GraspTaskTest {
  PlacedGraspTest() : GraspTaskTest({{kCube, {0.03, 0.0, 0.0}, Quat(std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5))}}) {}
};

TEST_F(PlacedGraspTest, AnObjectThatLiesElsewhereAtTheStartIsPickedUpFromThere) {
  reply(p_WD, 0);
  EXPECT_EQ(grasp->poses()[kCube].p_m.x(), 0.03);
  EXPECT_GT(grasp->poses()[kCube].serial, 1U);
  EXPECT_EQ(go({0.0, 0.0, -kPressDepth}, 0).object, kPlate) << "nothing is where the scene file has it";
  go({0.0, 0.0, 0.05}, 0);
  go({0.03, 0.0, 0.05}, 0);
  EXPECT_EQ(go({0.03, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  rest(1, 150);
  ASSERT_TRUE(step->holds_tool());
  go({0.03, 0.0, 0.04}, 1);
  go({0.01, 0.0, 0.04}, 1);
  go({0.01, 0.0, 0.021 - kPressDepth}, 1);
  rest(0, 1);
  wait_for_method(1);
  EXPECT_NEAR(grasp->poses()[kCube].p_m.x(), 0.01, 1e-4);
  EXPECT_NEAR(std::abs(grasp->poses()[kCube].q.z()), std::sqrt(0.5), 1e-3) << "its turn is kept";
  EXPECT_EQ(rest(0, 100).object, kCube);
}

struct WindyGraspTest : GraspTaskTest {
  WindyGraspTest() : GraspTaskTest({}, {{"wind", ConstantEffect{.force_n = {0.0, 0.3, 0.0}}}}) {}
};

TEST_F(WindyGraspTest, EffectsInFreeSpaceActWhileAnObjectIsHeldAndWhileItIsPutDown) {
  reply(p_WD, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  double largest_deviation_n = 0.0;
  const auto note_deviation = [&] { largest_deviation_n = std::max(largest_deviation_n, std::abs(last_reply.force_n.y() - 0.3)); };
  for (int i = 0; i < 200; ++i) {
    reply(p_WD, 1);
    note_deviation();
  }
  ASSERT_TRUE(step->holds_tool());
  EXPECT_NEAR((last_reply.force_n - Vec3(0.0, 0.3, 0.0)).norm(), 0.0, 1e-6);
  go({0.03, 0.0, 0.04}, 1);
  note_deviation();
  for (int i = 0; i < 200; ++i) {
    reply(p_WD, 0);
    note_deviation();
  }
  wait_for_method(1);
  rest(0, 200);
  note_deviation();
  EXPECT_LT(largest_deviation_n, 1e-6) << "never without the wind";
  EXPECT_TRUE(last_reply.contact);
}

struct SwitchedGraspTest : GraspTaskTest {
  SwitchedGraspTest() : GraspTaskTest({}, {{"wind", ConstantEffect{.force_n = {0.0, 0.3, 0.0}}, {.button = 2}}}) {}
};

TEST_F(SwitchedGraspTest, AnEffectThatIsOffInTheSceneWithTheObjectPutDownFadesOut) {
  reply(p_WD, 0);
  EXPECT_EQ(go({0.0, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  rest(1, 200);
  ASSERT_TRUE(step->holds_tool());
  go({0.03, 0.0, 0.04}, 3);
  EXPECT_NEAR(last_reply.force_n.y(), 0.3, 1e-6);
  largest_change_n = 0.0;
  delays_methods = true;
  for (int i = 0; i < 200; ++i) reply(p_WD + Vec3(0.0, 0.0, 5e-5), 2);  // away from the object
  delays_methods = false;
  for (int i = 0; i < 30'000 && method_changes < 1; ++i) {
    rest(2, 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_EQ(method_changes, 1);
  rest(2, 200);
  EXPECT_EQ(last_reply.force_n.y(), 0.0) << "a button that was down already does not switch it on";
  EXPECT_LT(largest_change_n, 0.04) << "a tenth in each step";
}

// vision_node makes such a request when a person undoes a move.
TEST_F(GraspTaskTest, AnObjectIsMovedOnRequestWhileAnotherIsTouched) {
  reply(p_WD, 0);
  go({-0.05, 0.0, 0.03}, 0);
  EXPECT_EQ(go({-0.05, 0.0, -kPressDepth}, 0).object, kPlate);
  ObjectPose requested_pose{.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = {0.03, 0.0, 0.0}};
  grasp->request_pose(requested_pose);
  rest(0, 1);
  EXPECT_EQ(grasp->poses()[kCube].p_m, requested_pose.p_m) << "announced at once";
  EXPECT_GT(grasp->poses()[kCube].serial, requested_pose.serial);
  grasp->request_pose(requested_pose);  // repeated, because a reply may be lost
  wait_for_method(1);
  rest(0, 200);
  EXPECT_EQ(last_reply.object, kPlate) << "the probe has not sunk in";
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 0.01);
  grasp->request_pose(requested_pose);
  rest(0, 50);
  EXPECT_FALSE(grasp->is_busy()) << "that pose has been left already";
  go({-0.05, 0.0, 0.05}, 0);
  go({0.03, 0.0, 0.05}, 0);
  EXPECT_EQ(go({0.03, 0.0, 0.021 - kPressDepth}, 0).object, kCube);
  // The cube leaves the place under the tip: nothing is left there to be felt.
  requested_pose = {.serial = grasp->poses()[kCube].serial, .object = kCube};
  grasp->request_pose(requested_pose);
  rest(0, 1);
  wait_for_method(2);
  rest(0, 200);
  EXPECT_EQ(last_reply.object, -1);
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-6);
  EXPECT_LT(largest_change_n, 800.0 * 1e-4 + 0.02) << "no force discontinuity";
}

TEST_F(GraspTaskTest, RequestsThatDoNotSuitAreIgnored) {
  reply(p_WD, 0);
  const std::uint32_t serial = grasp->poses()[kCube].serial;
  const Vec3 aside(0.03, 0.0, 0.0);
  for (const ObjectPose& bad : {ObjectPose{.serial = serial + 1, .object = kCube, .p_m = aside},
                                ObjectPose{.serial = serial, .object = kCube, .is_held = true, .p_m = aside},
                                ObjectPose{.serial = 0, .object = kPlate, .p_m = aside}, ObjectPose{.serial = serial, .object = 3},
                                ObjectPose{.serial = serial, .object = -1}}) {
    grasp->request_pose(bad);
    rest(0, 2);
    EXPECT_FALSE(grasp->is_busy()) << bad.object;
  }
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  rest(1, 150);
  ASSERT_TRUE(step->holds_tool());
  grasp->request_pose({.serial = grasp->poses()[kCube].serial, .object = kCube, .p_m = aside});
  rest(1, 10);
  EXPECT_TRUE(step->holds_tool()) << "not while it is held";
}

TEST_F(GraspTaskTest, ObjectsArePreparedWhenIdleAndOnlyMovedOnesAgain) {
  const auto run_until_idle = [this] {
    int runs = 0;
    while (task->run_once()) ++runs;
    return runs;
  };
  EXPECT_EQ(run_until_idle(), 3) << "one run for each object";
  reply(p_WD, 0);
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  go(p_WD, 1);
  ASSERT_TRUE(step->holds_tool());
  go({0.0, 0.0, 0.03}, 1);
  // Released: the request is carried out, then the cube is prepared where it is now.
  step->offer({.sample = ++sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p_WD});
  (void)step->reply();
  EXPECT_EQ(run_until_idle(), 2);
}

struct GraspOnImages : GraspTaskTest {
  static void put_images_on_the_plate(Scene& scene) {
    const std::shared_ptr<const TriangleMesh> mesh = scene.objects[kPlate].mesh;
    auto mapped = std::make_shared<std::vector<MappedTriangle>>(mesh->triangles.size());
    for (std::size_t t = 0; t < mapped->size(); ++t) {
      for (int k = 0; k < 3; ++k) (*mapped)[t].corner[static_cast<std::size_t>(k)] = mesh->corner(t, k);
    }
    const auto image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{0.5F});
    scene.objects[kPlate].effects.maps = {.triangles = mapped, .friction = {.image = image, .at_black = 0.0, .at_white = 1.0}};
  }
  GraspOnImages() : GraspTaskTest({}, {}, put_images_on_the_plate) {}
};

TEST_F(GraspOnImages, ASurfaceWithImagesIsPreparedAheadAndGoesIntoTheSceneThatIsBuilt) {
  int prepared = 0;
  while (task->run_once()) ++prepared;
  EXPECT_EQ(prepared, 4) << "three objects, and the images of one";
  reply(p_WD, 0);
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  go(p_WD, 1);
  ASSERT_TRUE(step->holds_tool());
  go({0.0, 0.0, 0.03}, 1);
  rest(0, 1);
  wait_for_method(1);
  ASSERT_EQ(felt_scenes.size(), 1U);
  ASSERT_EQ(felt_scenes[0].mapped.size(), 3U);
  ASSERT_NE(felt_scenes[0].mapped[kPlate], nullptr);
  EXPECT_EQ(felt_scenes[0].mapped[kPlate]->triangles(), scene.objects[kPlate].effects.maps.triangles);
  EXPECT_EQ(felt_scenes[0].mapped[kCube], nullptr);
}

TEST_F(GraspTaskTest, SaysHowLongAPickUpTookIfTheHandHadToWaitAndCountsTheTimesOfPoses) {
  reply(p_WD, 0);
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  const auto log_of_pick_up = [&](std::int64_t step_ns) {
    clock.step_ns = step_ns;
    const std::string log = log_of([&] { rest(1, 3); });
    EXPECT_TRUE(step->holds_tool());
    const int next = method_changes + 1;
    rest(0, 1);
    wait_for_method(next);
    rest(0, 200);
    return log;
  };
  EXPECT_THAT(log_of_pick_up(190'000'000), AllOf(HasSubstr("cube is picked up"), Not(HasSubstr("took"))));
  EXPECT_THAT(log_of_pick_up(300'000'000), HasSubstr("cube is picked up; its preparation took 0.3 s"));
  EXPECT_GT(task->pose_times().count(), 2U);
  EXPECT_NEAR(static_cast<double>(task->pose_times().max_ns()), 300e6, 1.0);
  EXPECT_LT(static_cast<double>(task->pose_times().min_ns()), 200e6);
}

TEST_F(GraspTaskTest, WhatIsNotMovableIsNotPickedUp) {
  reply(p_WD, 0);
  go({-0.05, 0.0, 0.03}, 0);
  EXPECT_EQ(go({-0.05, 0.0, -kPressDepth}, 0).object, kPlate);
  const Vec3 force_before_n = last_reply.force_n;
  rest(1, 200);
  EXPECT_FALSE(step->holds_tool());
  EXPECT_EQ(last_reply.force_n, force_before_n);
  EXPECT_FALSE(grasp->is_busy());
}

TEST_F(GraspTaskTest, AButtonThatWasDownBeforePicksUpNothingAndOneInTheAirNeither) {
  reply(p_WD, 1);
  go({0.0, 0.0, 0.021 - kPressDepth}, 1);
  EXPECT_FALSE(step->holds_tool());
  go({0.0, 0.0, 0.05}, 0);
  rest(1, 10);
  go({0.0, 0.0, 0.021 - kPressDepth}, 1);
  EXPECT_FALSE(step->holds_tool());
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
}

// The log says that an object stays if it was never picked up. It does not say so if the object was held and put down.
TEST_F(GraspTaskTest, SaysThatAnObjectStaysOnlyIfItWasNotPickedUp) {
  reply(p_WD, 0);
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  const std::string log_of_hold = log_of([&] {
    rest(1, 200);
    EXPECT_TRUE(step->holds_tool());
    rest(0, 200);
    EXPECT_FALSE(step->holds_tool());
  });
  EXPECT_THAT(log_of_hold, AllOf(HasSubstr("cube"), Not(HasSubstr("stays where it is"))));
  const std::string log_of_release = log_of([&] {
    for (const std::uint32_t buttons : {1U, 0U}) {  // released before the slow task has received the request
      step->offer({.sample = ++sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p_WD, .buttons = buttons});
      (void)step->reply();
    }
    rest(0, 200);
  });
  EXPECT_THAT(log_of_release, HasSubstr("cube stays where it is"));
}

TEST_F(GraspTaskTest, ABriefPressLeavesEverythingAsItWas) {
  reply(p_WD, 0);
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  for (int i = 0; i < 20; ++i) {
    // The slow task does not run between press and release, only after the release.
    step->offer({.sample = ++sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p_WD, .buttons = 1});
    (void)step->reply();
    rest(0, 1 + i % 3);
  }
  rest(0, 200);
  EXPECT_FALSE(grasp->is_busy());
  EXPECT_EQ(last_reply.object, kCube);
  EXPECT_NEAR(last_reply.force_n.z(), 800.0 * kPressDepth, 1e-3);
}

TEST_F(GraspTaskTest, TheStepUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  reply(p_WD, 0);
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  const auto step_once = [&](std::uint32_t buttons) {
    p_WD.z() += buttons == 0 ? 0.0 : 1e-5;
    step->offer({.sample = ++sample, .sample_time_ns = static_cast<std::int64_t>(sample) * 1'000'000, .p_WD = p_WD, .buttons = buttons});
    const AllocationGuard guard;
    last_reply = step->reply();
    return guard.count();
  };
  for (int n = 0; n < 600; ++n) {
    ASSERT_EQ(step_once(n < 400 ? 1 : 0), 0U) << n;
    if (n % 3 == 0) task->run_once();
  }
}

TEST_F(GraspTaskTest, TheSceneMayTurnWhileAnObjectIsHeld) {
  reply(p_WD, 0);
  go({0.0, 0.0, 0.021 - kPressDepth}, 0);
  go(p_WD, 1);
  go({0.0, 0.0, 0.04}, 1);
  ASSERT_TRUE(step->holds_tool());
  // A quarter turn about z: what was at x is at y now. The object stays with the stylus.
  ASSERT_TRUE(step->turn_scene({.revision = 1, .X_WS = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}}));
  rest(1, 100);
  EXPECT_NEAR(last_reply.force_n.norm(), 0.0, 1e-6);
  go({0.0, 0.041, 0.04}, 1);
  EXPECT_NEAR(last_reply.force_n.y(), -800.0 * 0.001, 0.01) << "the wall has turned";
  go({0.0, 0.03, 0.04}, 1);
  rest(0, 1);
  wait_for_method(1);
  EXPECT_NEAR(grasp->poses()[kCube].p_m.x(), 0.03, 1e-4);
}

}  // namespace
}  // namespace hapton
