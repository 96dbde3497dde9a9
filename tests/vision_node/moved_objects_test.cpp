#include "vision_node/moved_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

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
      shown.push_back({object.mesh, Vec3(colour.data())});
    };
    add(kRedAt, {1, 0, 0});
    add(kGreenAt, {0, 1, 0});
    view = open_or_fail(plain_settings(StereoMode::mono, 640, 480), shown);
  }
  std::optional<Vec2> find(int channel) {
    view->draw();
    return centroid(view->read_picture(), channel, 0, 640);
  }
  Vec2 expected(const Vec3& p) const { return project_to_pixel(view->screen(), Eye::centre, {640, 480}, p); }

  Scene scene;
  std::vector<ShownObject> shown;
  std::unique_ptr<StereoView> view;
};

TEST_F(MovedObjectsTest, AnObjectIsDrawnWhereItWasPutDown) {
  ASSERT_TRUE(view);
  MovedObjects moved(*view, scene);
  EXPECT_LT((*find(0) - expected(kRedAt)).norm(), 0.6);
  const Vec3 by(0.03, -0.06, 0.02);
  const Quat turned(Eigen::AngleAxisd(0.5, Vec3::UnitZ()));
  EXPECT_TRUE(moved.take({.serial = 2, .object = 0, .p_m = by, .q = turned}));
  EXPECT_LT((*find(0) - expected(turned * kRedAt + by)).norm(), 0.6);
  EXPECT_LT((*find(1) - expected(kGreenAt)).norm(), 0.6) << "the other stays";
  EXPECT_FALSE(moved.take({.serial = 2, .object = 0, .p_m = by, .q = turned})) << "said again";
  EXPECT_TRUE(moved.take({.serial = 1, .object = 0})) << "of another haptics node: where the scene file has it";
  EXPECT_LT((*find(0) - expected(kRedAt)).norm(), 0.6);
}

TEST_F(MovedObjectsTest, AnObjectThatIsHeldGoesWithTheStylus) {
  ASSERT_TRUE(view);
  MovedObjects moved(*view, scene);
  const Vec3 tip(0.02, -0.05, 0.01);
  ProbeShown probe;
  probe.p_WP = probe.p_WD = tip;
  view->set_probe(probe);
  view->draw();
  const Vec2 there = expected(tip + Vec3(0.01, 0, 0));
  const Picture empty_handed = view->read_picture();
  const std::uint8_t* beside = empty_handed.at(static_cast<int>(there.x()), static_cast<int>(there.y()));
  const std::array<std::uint8_t, 3> bare = {beside[0], beside[1], beside[2]};
  // Held a centimetre beside the tip.
  EXPECT_TRUE(moved.take({.serial = 2, .object = 0, .is_held = true, .p_m = Vec3(0.01, 0, 0) - kRedAt}));
  EXPECT_EQ(moved.held(), 0);
  view->set_probe(probe);
  view->draw();
  const Picture held = view->read_picture();
  const std::uint8_t* red = held.at(static_cast<int>(there.x()), static_cast<int>(there.y()));
  EXPECT_GT(red[0], 60);
  EXPECT_LT(red[1], red[0] / 2);
  EXPECT_FALSE(std::equal(red, red + 3, bare.begin()));
  const Vec3 down(0.0, 0.02, 0.0);
  EXPECT_TRUE(moved.take({.serial = 3, .object = 0, .p_m = down}));
  EXPECT_EQ(moved.held(), -1);
  view->set_probe(probe);
  view->draw();
  const Picture picture = view->read_picture();
  const auto at = expected(kRedAt + down);
  const std::uint8_t* middle = picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
  EXPECT_GT(middle[0], 200);
  EXPECT_EQ(middle[1], 0);
  const std::uint8_t* after = picture.at(static_cast<int>(there.x()), static_cast<int>(there.y()));
  EXPECT_TRUE(std::equal(after, after + 3, bare.begin())) << "the stylus holds it no more";
}

// Where the felt one is at that time: both evaluate the same keyframes.
TEST_F(MovedObjectsTest, AnObjectThatMovesByKeyframesIsDrawnWhereItIsAtThatTime) {
  ASSERT_TRUE(view);
  const auto motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3(0.01, 0, 0), Quat::Identity()}, {2.0, Vec3(0.05, -0.06, 0.02), Quat::Identity()}},
      false);
  scene.objects[0].motion = motion;
  MovedObjects moved(*view, scene);
  EXPECT_TRUE(moved.has_motion());
  EXPECT_LT((*find(0) - expected(kRedAt + Vec3(0.01, 0, 0))).norm(), 0.6) << "where it begins";
  EXPECT_TRUE(moved.set_time(1'500'000'000));
  EXPECT_FALSE(moved.set_time(1'500'000'000)) << "the same again";
  moved.place_moving();
  EXPECT_LT((*find(0) - expected(motion->pose_at(1.5) * kRedAt)).norm(), 0.6);
  EXPECT_LT((*find(1) - expected(kGreenAt)).norm(), 0.6) << "the other stays";
  EXPECT_EQ(moved.moving()[0].matrix(), motion->pose_at(1.5).matrix());
  EXPECT_FALSE(moved.take({.serial = 2, .object = 0, .p_m = Vec3::UnitX()})) << "nobody picks it up";
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
  EXPECT_FALSE(moved.take({.serial = 2, .object = 2, .p_m = Vec3::UnitX()}));
  EXPECT_FALSE(moved.take({.serial = 2, .object = -1, .p_m = Vec3::UnitX()}));
}

}  // namespace
}  // namespace hapton
