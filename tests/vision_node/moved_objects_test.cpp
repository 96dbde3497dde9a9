#include "vision_node/moved_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>

#include "link/commanded_move.h"
#include "scene/object_reader.h"
#include "tests/vision_node/made_views.h"

namespace hapton {
namespace {

constexpr double kRadius = 0.004;
const Vec3 kRedAt(-0.05, 0.04, 0.0);
const Vec3 kGreenAt(0.01, 0.0, 0.0);

struct MovedObjectsTest : testing::Test {
  MovedObjectsTest() {
    const auto add = [&](const Vec3& at, const std::array<double, 3>& colour) {
      SceneObject object;
      object.mesh = make_marker(at, kRadius);
      object.colour = colour;
      scene.objects.push_back(object);
      shown_objects.push_back({object.mesh, Vec3(colour.data())});
    };
    add(kRedAt, {1, 0, 0});
    add(kGreenAt, {0, 1, 0});
    view = open_or_fail(plain_settings(StereoMode::mono, 640, 480), shown_objects);
  }
  // The pixel of the red (0) or the green marker (1).
  std::optional<Vec2> find_marker(int channel) {
    view->draw();
    return centroid(view->read_picture(), channel, 0, 640);
  }
  Vec2 pixel_of(const Vec3& p) const { return project_to_pixel(view->screen(), Eye::centre, {640, 480}, p); }

  Scene scene;
  std::vector<ShownObject> shown_objects;
  std::unique_ptr<StereoView> view;
};

TEST_F(MovedObjectsTest, AnObjectIsDrawnWhereItWasPutDown) {
  ASSERT_TRUE(view);
  MovedObjects moved(*view, scene);
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6);
  const Vec3 by(0.03, -0.06, 0.02);
  const Quat turned(Eigen::AngleAxisd(0.5, Vec3::UnitZ()));
  EXPECT_TRUE(moved.take(ObjectPose{.serial = 2, .object = 0, .p_m = by, .q = turned}));
  EXPECT_LT((*find_marker(0) - pixel_of(turned * kRedAt + by)).norm(), 0.6);
  EXPECT_LT((*find_marker(1) - pixel_of(kGreenAt)).norm(), 0.6) << "the other stays";
  EXPECT_FALSE(moved.take(ObjectPose{.serial = 2, .object = 0, .p_m = by, .q = turned})) << "sent again";
  EXPECT_TRUE(moved.take(ObjectPose{.serial = 1, .object = 0})) << "of another haptics node: where the scene file has it";
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6);
}

// The pose of the pick-up arrives again, after the pose that puts the object down: the object must not be drawn at the stylus again.
TEST_F(MovedObjectsTest, APoseThatANewerOneOvertookIsIgnored) {
  ASSERT_TRUE(view);
  MovedObjects moved(*view, scene);
  const ObjectPose held{.serial = 2, .object = 0, .is_held = true};
  EXPECT_FALSE(moved.is_overtaken(held, Arrival::reordered)) << "nothing is known of this object";
  EXPECT_TRUE(moved.take(ObjectPose{.serial = 3, .object = 0, .p_m = Vec3(0.0, 0.02, 0.0)}));
  EXPECT_TRUE(moved.is_overtaken(held, Arrival::reordered));
  EXPECT_FALSE(moved.is_overtaken(held, Arrival::newest)) << "of another haptics node";
  EXPECT_FALSE(moved.is_overtaken({.serial = 2, .object = 1}, Arrival::reordered)) << "of another object";
  EXPECT_FALSE(moved.is_overtaken({.serial = 2, .object = 7}, Arrival::reordered));
}

TEST_F(MovedObjectsTest, AnObjectThatIsHeldGoesWithTheStylus) {
  ASSERT_TRUE(view);
  MovedObjects moved(*view, scene);
  const Vec3 tip(0.02, -0.05, 0.01);
  ProbeShown probe;
  probe.p_WP = probe.p_WD = tip;
  view->set_probe(probe);
  view->draw();
  const Vec2 there = pixel_of(tip + Vec3(0.01, 0, 0));
  const Picture without_object = view->read_picture();
  const std::uint8_t* beside = without_object.at(static_cast<int>(there.x()), static_cast<int>(there.y()));
  const std::array<std::uint8_t, 3> background = {beside[0], beside[1], beside[2]};
  // The object is held a centimetre beside the tip.
  EXPECT_TRUE(moved.take(ObjectPose{.serial = 2, .object = 0, .is_held = true, .p_m = Vec3(0.01, 0, 0) - kRedAt}));
  EXPECT_EQ(moved.held(), 0);
  view->set_probe(probe);
  view->draw();
  const Picture held = view->read_picture();
  const std::uint8_t* red = held.at(static_cast<int>(there.x()), static_cast<int>(there.y()));
  EXPECT_GT(red[0], 60);
  EXPECT_LT(red[1], red[0] / 2);
  EXPECT_FALSE(std::equal(red, red + 3, background.begin()));
  const Vec3 down(0.0, 0.02, 0.0);
  EXPECT_TRUE(moved.take(ObjectPose{.serial = 3, .object = 0, .p_m = down}));
  EXPECT_EQ(moved.held(), -1);
  view->set_probe(probe);
  view->draw();
  const Picture picture = view->read_picture();
  const auto at = pixel_of(kRedAt + down);
  const std::uint8_t* middle = picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
  EXPECT_GT(middle[0], 200);
  EXPECT_EQ(middle[1], 0);
  const std::uint8_t* after = picture.at(static_cast<int>(there.x()), static_cast<int>(there.y()));
  EXPECT_TRUE(std::equal(after, after + 3, background.begin())) << "the stylus holds it no more";
}

// The object is drawn where it is felt at that time, because both nodes evaluate the same keyframes.
TEST_F(MovedObjectsTest, AnObjectThatMovesByKeyframesIsDrawnWhereItIsAtThatTime) {
  ASSERT_TRUE(view);
  const auto motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3(0.01, 0, 0), Quat::Identity()}, {2.0, Vec3(0.05, -0.06, 0.02), Quat::Identity()}},
      false);
  scene.objects[0].motion = motion;
  MovedObjects moved(*view, scene);
  EXPECT_TRUE(moved.has_motion());
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt + Vec3(0.01, 0, 0))).norm(), 0.6) << "where it begins";
  EXPECT_TRUE(moved.set_time(1'500'000'000));
  EXPECT_FALSE(moved.set_time(1'500'000'000)) << "the same again";
  moved.place_moving();
  EXPECT_LT((*find_marker(0) - pixel_of(motion->pose_at(1.5) * kRedAt)).norm(), 0.6);
  EXPECT_LT((*find_marker(1) - pixel_of(kGreenAt)).norm(), 0.6) << "the other stays";
  EXPECT_EQ(moved.moving()[0].matrix(), motion->pose_at(1.5).matrix());
  EXPECT_FALSE(moved.take(ObjectPose{.serial = 2, .object = 0, .p_m = Vec3::UnitX()})) << "nobody picks it up";
}

SceneObject commanded_marker(const SceneObject& marker, const Vec3& pivot_m = Vec3::Zero()) {
  SceneObject object = marker;
  ObjectSpec spec;
  spec.motion.by_program = true;
  spec.motion.p_MP = pivot_m;
  object.commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *object.mesh);
  return object;
}

// The object is drawn where it was felt at the scene time of the sample shown, even if that is before the newest move.
TEST_F(MovedObjectsTest, AnObjectThatAProgramMovesIsDrawnWhereItIsAtThatTime) {
  ASSERT_TRUE(view);
  scene.objects[0] = commanded_marker(scene.objects[0]);
  MovedObjects moved(*view, scene);
  EXPECT_TRUE(moved.has_motion());
  EXPECT_FALSE(moved.set_time(400'000'000));
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6) << "at rest";
  ObjectMove first{.source = 5, .serial = 1, .start_ns = 500'000'000, .end_ns = 1'500'000'000, .to_p_m = Vec3(0.04, -0.06, 0.02)};
  first.to_q = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
  ASSERT_TRUE(moved.take(first));
  EXPECT_FALSE(moved.take(first)) << "announced again";
  EXPECT_FALSE(moved.set_time(450'000'000)) << "from before its start";
  EXPECT_TRUE(moved.set_time(1'250'000'000));
  moved.place_moving();
  CommandedMotion felt(scene.objects[0].commanded->pivot());
  felt.begin(to_command(first));
  EXPECT_EQ(moved.moving()[0].matrix(), felt.pose_at(1e-9 * 1'250'000'000).matrix());
  EXPECT_LT((*find_marker(0) - pixel_of(felt.pose_at(1.25) * kRedAt)).norm(), 0.6);
  EXPECT_LT((*find_marker(1) - pixel_of(kGreenAt)).norm(), 0.6) << "the other stays";
  // A newer move takes over at 1.3 s; a sample of 1.2 s is still shown as it was felt.
  const Keyframe at_takeover = felt.keyframe_at(1.3);
  ASSERT_TRUE(moved.take(ObjectMove{.source = 5,
                                    .serial = 2,
                                    .start_ns = 1'300'000'000,
                                    .end_ns = 2'000'000'000,
                                    .from_p_m = at_takeover.p_S,
                                    .from_q = at_takeover.turn}));
  moved.set_time(1'200'000'000);
  EXPECT_EQ(moved.moving()[0].matrix(), felt.pose_at(1e-9 * 1'200'000'000).matrix());
  moved.set_time(3'000'000'000);
  EXPECT_EQ(moved.moving()[0].matrix(), Pose::Identity().matrix());
}

// The scene time and the serials of another process begin again.
TEST_F(MovedObjectsTest, AnotherHapticsProcessHasOtherMoves) {
  ASSERT_TRUE(view);
  scene.objects[0] = commanded_marker(scene.objects[0]);
  MovedObjects moved(*view, scene);
  const Vec3 there(0.04, -0.06, 0.02);
  ASSERT_TRUE(moved.take(ObjectMove{.source = 5, .serial = 9, .start_ns = 1, .end_ns = 2, .to_p_m = there}));
  moved.set_time(1'000'000'000);
  EXPECT_EQ(moved.moving()[0].translation(), there);
  EXPECT_FALSE(moved.take(ObjectMove{.source = 6, .serial = 0})) << "not moved yet";
  EXPECT_TRUE(moved.set_time(1'000'000'000));
  EXPECT_EQ(moved.moving()[0].matrix(), Pose::Identity().matrix());
  EXPECT_TRUE(moved.take(ObjectMove{.source = 6, .serial = 1, .start_ns = 1, .end_ns = 2, .to_p_m = there}));
}

// A move of the previous process arrives late: the object is felt where the scene file puts it, and is drawn there.
TEST_F(MovedObjectsTest, AnOvertakenMoveOfThePreviousProcessIsLeftOut) {
  ASSERT_TRUE(view);
  scene.objects[0] = commanded_marker(scene.objects[0]);
  MovedObjects moved(*view, scene);
  const Vec3 there(0.04, -0.06, 0.02);
  ASSERT_TRUE(moved.take(ObjectMove{.source = 5, .serial = 9, .start_ns = 1, .end_ns = 2, .to_p_m = there}));
  EXPECT_FALSE(moved.take(ObjectMove{.source = 6, .serial = 0})) << "not moved yet";
  EXPECT_FALSE(moved.take(ObjectMove{.source = 5, .serial = 10, .start_ns = 3, .end_ns = 4, .to_p_m = there}, Arrival::reordered));
  moved.set_time(1'000'000'000);
  EXPECT_EQ(moved.moving()[0].matrix(), Pose::Identity().matrix());
}

TEST_F(MovedObjectsTest, ProgramsMoveNoOtherObjects) {
  ASSERT_TRUE(view);
  scene.objects[0] = commanded_marker(scene.objects[0]);
  MovedObjects moved(*view, scene);
  for (const std::int32_t object : {-1, 1, 2, 1'000'000}) {
    EXPECT_FALSE(moved.take(ObjectMove{.source = 5, .serial = 1, .object = object, .to_p_m = Vec3::UnitX()})) << object;
  }
  EXPECT_FALSE(moved.take(ObjectPose{.serial = 2, .object = 0, .p_m = Vec3::UnitX()})) << "nobody picks it up";
}

// The object is drawn in its shape of that time: at 1 s it has moved to the right by half of 60 mm.
TEST_F(MovedObjectsTest, AnObjectThatDeformsIsDrawnInItsShapeOfThatTime) {
  ASSERT_TRUE(view);
  MorphTarget target;
  for (std::uint32_t v = 0; v < scene.objects[0].mesh->vertices.size(); ++v) {
    target.vertices.push_back(v);
    target.displacements.push_back({0.06, 0.0, 0.0});
  }
  scene.objects[0].deformation =
      std::make_shared<const MeshDeformation>(std::vector{target}, std::vector<MorphKey>{{0.0, {0.0}}, {2.0, {1.0}}}, false);
  MovedObjects moved(*view, scene);
  EXPECT_TRUE(moved.has_motion());
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6);
  EXPECT_TRUE(moved.set_time(1'000'000'000));
  moved.place_moving();
  EXPECT_FALSE(moved.set_time(1'000'000'000)) << "the same again";
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt + Vec3(0.03, 0, 0))).norm(), 0.6);
  EXPECT_LT((*find_marker(1) - pixel_of(kGreenAt)).norm(), 0.6) << "the other stays";
  EXPECT_FALSE(moved.take(ObjectPose{.serial = 2, .object = 0, .p_m = Vec3::UnitX()})) << "nobody picks it up";
}

// A program moves it to the right by 60 mm; at 1.5 s half of the time is over.
TEST_F(MovedObjectsTest, AnObjectThatAProgramDeformsIsDrawnInItsShapeOfThatTime) {
  ASSERT_TRUE(view);
  scene.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.1});
  MovedObjects moved(*view, scene);
  EXPECT_TRUE(moved.has_motion());
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6);
  const auto total = static_cast<std::uint32_t>(scene.objects[0].mesh->vertices.size());
  const ShapeStart start{.source = 5, .serial = 1, .total = total, .start_ns = 1'000'000'000, .end_ns = 2'000'000'000};
  moved.take(start, Arrival::newest);
  EXPECT_FALSE(moved.set_time(1'500'000'000)) << "its vertices have not come";
  moved.place_moving();
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6);
  ASSERT_FALSE(moved.take_shape_request(0));
  const auto request = moved.take_shape_request(1'000'000'000);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->serial, 1U);
  for (std::uint32_t first = 0; first < total; first += ShapePart::kVerticesPerPart) {
    ObjectShape part{.source = 5, .serial = 1, .part = {.total = total, .first = first}};
    part.part.displacements_m.fill({0.06F, 0.0F, 0.0F});
    moved.take(part, Arrival::newest);
  }
  EXPECT_TRUE(moved.set_time(1'500'000'000));
  moved.place_moving();
  EXPECT_FALSE(moved.set_time(1'500'000'000)) << "the same again";
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt + Vec3(0.03, 0, 0))).norm(), 0.6);
  EXPECT_LT((*find_marker(1) - pixel_of(kGreenAt)).norm(), 0.6) << "the other stays";
  moved.set_time(3'000'000'000);
  moved.place_moving();
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt + Vec3(0.06, 0, 0))).norm(), 0.6);
  moved.set_time(900'000'000);
  moved.place_moving();
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6) << "a sample from before the move";
  // With another haptics process the object is at rest.
  moved.set_time(3'000'000'000);
  moved.place_moving();
  moved.take(ShapeStart{.source = 6, .total = total}, Arrival::newest);
  EXPECT_TRUE(moved.set_time(3'000'000'000));
  moved.place_moving();
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6);
}

TEST_F(MovedObjectsTest, NothingMovesInASceneWithoutKeyframes) {
  ASSERT_TRUE(view);
  MovedObjects moved(*view, scene);
  EXPECT_FALSE(moved.has_motion());
  EXPECT_FALSE(moved.set_time(1'500'000'000));
}

TEST_F(MovedObjectsTest, AnObjectThatTheSceneDoesNotHaveIsLeftOut) {
  ASSERT_TRUE(view);
  MovedObjects moved(*view, scene);
  EXPECT_FALSE(moved.take(ObjectPose{.serial = 2, .object = 2, .p_m = Vec3::UnitX()}));
  EXPECT_FALSE(moved.take(ObjectPose{.serial = 2, .object = -1, .p_m = Vec3::UnitX()}));
}

// This happens when the scene file was saved and its scene is shown again: what is felt has not moved.
TEST_F(MovedObjectsTest, InASceneOfTheSameObjectsTheyAreWhereTheyWerePut) {
  ASSERT_TRUE(view);
  scene.objects[0].name = "red";
  scene.objects[1].name = "green";
  MovedObjects before(*view, scene);
  const Vec3 by(0.03, -0.06, 0.02);
  const Vec3 beside_tip(0.01, 0.0, 0.0);
  ASSERT_TRUE(before.take(ObjectPose{.serial = 2, .object = 0, .p_m = by}));
  ASSERT_TRUE(before.take(ObjectPose{.serial = 3, .object = 1, .is_held = true, .p_m = beside_tip}));
  const Scene again = scene;
  ASSERT_TRUE(view->replace_scene(shown_objects, {}));
  MovedObjects after(*view, again);
  after.adopt(before);
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt + by)).norm(), 0.6);
  EXPECT_FALSE(find_marker(1)) << "it is at the stylus, which is not drawn";
  EXPECT_EQ(after.held(), 1);
  EXPECT_EQ(after.held_pose().translation(), beside_tip);
  EXPECT_EQ(after.poses()[0].translation(), by);
  Scene other = scene;
  other.objects[0].name = "blue";
  ASSERT_TRUE(view->replace_scene(shown_objects, {}));
  MovedObjects anew(*view, other);
  anew.adopt(after);
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6) << "the numbers are those of other objects";
  EXPECT_LT((*find_marker(1) - pixel_of(kGreenAt)).norm(), 0.6);
  EXPECT_EQ(anew.held(), -1);
}

// The haptics process announces the move again with the same serial: the move must not begin again.
TEST_F(MovedObjectsTest, InASceneOfTheSameObjectsTheyAreWhereProgramsMovedThem) {
  ASSERT_TRUE(view);
  scene.objects[0].name = "red";
  scene.objects[0] = commanded_marker(scene.objects[0]);
  MovedObjects before(*view, scene);
  const Vec3 there(0.04, -0.06, 0.02);
  const ObjectMove move{.source = 5, .serial = 9, .start_ns = 1, .end_ns = 2, .to_p_m = there};
  ASSERT_TRUE(before.take(move));
  before.set_time(1'000'000'000);
  const Scene again = scene;
  ASSERT_TRUE(view->replace_scene(shown_objects, {}));
  MovedObjects after(*view, again);
  after.adopt(before);
  EXPECT_EQ(after.moving()[0].translation(), there);
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt + there)).norm(), 0.6);
  EXPECT_FALSE(after.take(move)) << "it is known";
  // With another pivot the same move leads elsewhere, and the haptics node has not moved that object yet.
  Scene other = scene;
  other.objects[0] = commanded_marker(scene.objects[0], Vec3(0.01, 0.0, 0.0));
  ASSERT_TRUE(view->replace_scene(shown_objects, {}));
  MovedObjects anew(*view, other);
  anew.adopt(after);
  EXPECT_EQ(anew.moving()[0].matrix(), Pose::Identity().matrix());
  EXPECT_LT((*find_marker(0) - pixel_of(kRedAt)).norm(), 0.6);
}

}  // namespace
}  // namespace hapton
