#include "scene/object_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A triangle of 0.1 m, its corner at the origin of the mesh.
struct ObjectMotion : testing::Test {
  ObjectMotion() { folder.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n"); }

  Result<Scene> load(const std::string& text) { return load_scene(folder.write("a.toml", text)); }
  Result<Scene> load_object(const std::string& object, const std::string& keyframes, const std::string& head = "") {
    return load(head + "[[object]]\nname = 'flap'\nmesh = 'a.obj'\n" + object + "\n" + keyframes);
  }
  std::string error_of(const std::string& object, const std::string& keyframes, const std::string& head = "") {
    const auto scene = load_object(object, keyframes, head);
    return scene ? "it was read" : scene.error().what;
  }
  static std::string keyframe(const std::string& text) { return "[[object.keyframe]]\n" + text + "\n"; }

  ScratchFolder folder;
};

// A keyframe places the object as the object's own keys do, with position and rotation of the keyframe instead of those keys.
TEST_F(ObjectMotion, APlaceOfAKeyframeIsThatOfTheObjectThen) {
  const auto scene = load_object("position_m = [0, 0, 0.01]\nrotation_deg = [0, 0, 30]\nscale = 2",
                                 keyframe("time_s = 0") + keyframe("time_s = 2\nposition_m = [0.02, 0, 0]\nrotation_deg = [0, 0, 90]"));
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& flap = scene->objects[0];
  ASSERT_TRUE(flap.motion);
  EXPECT_EQ(flap.motion->pose_at(0.0).matrix(), Pose::Identity().matrix()) << "the first is as at rest";
  const Pose X_SO = flap.motion->pose_at(2.0);
  EXPECT_LT((X_SO * flap.mesh->vertices[0] - Vec3(0.02, 0, 0)).norm(), 1e-15);
  EXPECT_LT((X_SO * flap.mesh->vertices[1] - Vec3(0.02, 0.2, 0)).norm(), 1e-15);
  EXPECT_LT((flap.motion->pose_at(1.0) * flap.mesh->vertices[0] - Vec3(0.01, 0, 0.005)).norm(), 1e-15);
  EXPECT_FALSE(flap.motion->loops());
  EXPECT_EQ(scene->touch_scene().objects[0].motion, flap.motion);
}

TEST_F(ObjectMotion, ThePivotStaysWhereNoPlaceIsGiven) {
  const auto scene = load_object("position_m = [0, 0, 0.01]\npivot_m = [0.1, 0, 0]",
                                 keyframe("time_s = 0") + keyframe("time_s = 2\nrotation_deg = [0, 0, 90]"));
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& flap = scene->objects[0];
  for (const double time : {0.0, 0.7, 2.0}) {
    EXPECT_LT((flap.motion->pose_at(time) * flap.mesh->vertices[1] - Vec3(0.1, 0, 0.01)).norm(), 1e-15) << time;
  }
  EXPECT_LT((flap.motion->pose_at(2.0) * flap.mesh->vertices[0] - Vec3(0.1, -0.1, 0.01)).norm(), 1e-15);
}

TEST_F(ObjectMotion, IsFittedWithTheScene) {
  const auto scene = load_object("position_m = [5, 0, 0]\npivot_m = [0.1, 0, 0]",
                                 keyframe("time_s = 0") + keyframe("time_s = 4\nposition_m = [5.2, 0, 0]"), "fit_m = [0.05, 1, 1]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  // fit_m halves the scene: 0.2 m become 0.1 m.
  EXPECT_LT((scene->objects[0].motion->pose_at(4.0).translation() - Vec3(0.1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((scene->objects[0].motion->pivot() - Vec3(0.025, -0.025, 0)).norm(), 1e-12);
}

TEST_F(ObjectMotion, ASurfaceMayNotMoveFasterThanTheLimit) {
  // The farthest vertex is 0.1 m from the pivot: it moves 157 mm in a quarter of a turn.
  const std::string at_rest = keyframe("time_s = 0");
  EXPECT_THAT(error_of("", at_rest + keyframe("time_s = 0.5\nrotation_deg = [0, 0, 90]")),
              AllOf(HasSubstr("a.toml: line 7: before keyframe 2 'flap' moves at up to 0.314 m/s"),
                    HasSubstr("0.25 m/s at most: give it 0.629 s")));
  EXPECT_EQ(error_of("", at_rest + keyframe("time_s = 0.629\nrotation_deg = [0, 0, 90]")), "it was read");
  EXPECT_THAT(error_of("", at_rest + keyframe("time_s = 1\nposition_m = [0, 0.26, 0]")), HasSubstr("give it 1.040 s"));
  EXPECT_EQ(error_of("", at_rest + keyframe("time_s = 1\nposition_m = [0, 0.25, 0]")), "it was read");
}

TEST_F(ObjectMotion, ALoopEndsWhereItBegins) {
  const std::string keyframes = keyframe("time_s = 0") + keyframe("time_s = 1\nposition_m = [0.1, 0, 0]\nrotation_deg = [0, 0, 10]");
  EXPECT_THAT(error_of("loop = true", keyframes), HasSubstr("line 7: the last keyframe of 'flap' has another pose than the first"));
  const auto scene = load_object("loop = true", keyframes + keyframe("time_s = 2\nrotation_deg = [0, 0, 360]"));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_TRUE(scene->objects[0].motion->loops());
  EXPECT_EQ(scene->objects[0].motion->pose_at(2.0).matrix(), scene->objects[0].motion->pose_at(4.0).matrix());
}

// Numbers in a file have few digits: if the last pose differs from the first only by rounding, the loop ends exactly at the first.
TEST_F(ObjectMotion, ALoopThatEndsNextToItsBeginningEndsThere) {
  const std::string first_keyframes = keyframe("time_s = 0\nposition_m = [0, 0, 0]\nrotation_deg = [0, 0, 0]") +
                                      keyframe("time_s = 2\nposition_m = [0, 0.01, 0]\nrotation_deg = [0, 0, 30]");
  const auto scene =
      load_object("loop = true", first_keyframes + keyframe("time_s = 4\nposition_m = [3e-7, 0, 0]\nrotation_deg = [0, 0, 1e-4]"));
  ASSERT_TRUE(scene) << scene.error().what;
  const std::vector<Keyframe>& keyframes = scene->objects[0].motion->keyframes();
  EXPECT_EQ(keyframes.back().p_S, keyframes.front().p_S);
  EXPECT_EQ(keyframes.back().turn.coeffs(), keyframes.front().turn.coeffs());
  EXPECT_THAT(error_of("loop = true", first_keyframes + keyframe("time_s = 4\nposition_m = [0, 0, 0]\nrotation_deg = [0, 0, 1]")),
              HasSubstr("has another pose than the first"))
      << "turned in its place";
}

TEST_F(ObjectMotion, HalfATurnAtOnceHasNoDirection) {
  EXPECT_THAT(error_of("", keyframe("time_s = 0") + keyframe("time_s = 9\nrotation_deg = [0, 180, 0]")),
              HasSubstr("line 7: keyframe 2 of 'flap' is half a turn from the one before"));
}

TEST_F(ObjectMotion, HasTheEffectsOfItsMaterial) {
  const auto scene = load_object("material = 'm'", keyframe("time_s = 0") + keyframe("time_s = 1\nposition_m = [0, 0, 0.01]") +
                                                       "[material.m]\nviscosity_ns_per_m = 1\nsnap_range_m = 0.002\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const TouchScene touch = scene->touch_scene();
  EXPECT_NE(touch.objects[0].motion, nullptr);
  EXPECT_EQ(touch.objects[0].effects.viscosity.damping_ns_per_m, 1.0);
  EXPECT_EQ(touch.objects[0].effects.snap.range_m, 0.002);
}

TEST_F(ObjectMotion, RejectsMovableObjectsAndTools) {
  const std::string still = keyframe("time_s = 0") + keyframe("time_s = 1");
  EXPECT_THAT(error_of("movable = true", still), HasSubstr("line 4: [[object]] 1 is movable and moves by itself: keep one"));
  const auto tool = load("[[object]]\nmesh = 'a.obj'\n[tool]\nmesh = 'a.obj'\n[[tool.keyframe]]\ntime_s = 0\n");
  ASSERT_FALSE(tool);
  EXPECT_THAT(tool.error().what, HasSubstr("unknown key 'keyframe' in [tool]"));
}

// `hapton session replay` needs a scene with the same hash_scene(); haptics node and vision node compare given_hash.
TEST_F(ObjectMotion, IsPartOfTheScenesHashes) {
  const auto scene = [&](const std::string& object, const std::string& end) {
    return *load_object(object, end.empty() ? "" : keyframe("time_s = 0") + keyframe(end));
  };
  const Scene still = scene("", "");
  const Scene moving = scene("", "time_s = 1\nposition_m = [0.1, 0, 0]");
  for (const Scene& other : {still, scene("", "time_s = 1.5\nposition_m = [0.1, 0, 0]"), scene("", "time_s = 1\nposition_m = [0.11, 0, 0]"),
                             scene("pivot_m = [0.01, 0, 0]", "time_s = 1\nposition_m = [0.1, 0, 0]")}) {
    EXPECT_NE(hash_scene(moving.touch_scene()), hash_scene(other.touch_scene()));
    EXPECT_NE(moving.given_hash, other.given_hash);
  }
  EXPECT_EQ(hash_scene(moving.touch_scene()), hash_scene(scene("", "time_s = 1\nposition_m = [0.1, 0, 0]").touch_scene()));
}

TEST_F(ObjectMotion, TheExampleSceneMoves) {
  const auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/machine.toml");
  ASSERT_TRUE(scene) << scene.error().what;
  int moving_objects = 0;
  for (const SceneObject& object : scene->objects) moving_objects += object.motion != nullptr ? 1 : 0;
  EXPECT_EQ(moving_objects, 3);
  // The open lid's free edge is up, the closed one's just over the box.
  const SceneObject& lid = scene->objects[4];
  const SceneObject& box = scene->objects[3];
  const auto lowest = [](const SceneObject& object, double time_s) {
    double low = 1.0;
    for (const Vec3& vertex : object.mesh->vertices)
      low = std::min(low, (object.motion ? Vec3(object.motion->pose_at(time_s) * vertex) : vertex).y());
    return low;
  };
  const auto highest = [](const SceneObject& object, double time_s) {
    double high = -1.0;
    for (const Vec3& vertex : object.mesh->vertices)
      high = std::max(high, (object.motion ? Vec3(object.motion->pose_at(time_s) * vertex) : vertex).y());
    return high;
  };
  EXPECT_NEAR(lowest(lid, 0.0) - highest(box, 0.0), 0.0005, 1e-4);
  EXPECT_GT(highest(lid, 2.0), highest(lid, 0.0) + 0.045);
}

}  // namespace
}  // namespace hapton
