#include "haptics_node/scene_motion.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "scene/object_reader.h"

namespace hapton {
namespace {

Scene moving_scene_with(bool moves, bool is_movable) {
  Scene scene;
  scene.objects.push_back({.name = "lid", .mesh = nullptr, .material = {}});
  scene.objects.push_back({.name = "peg", .mesh = nullptr, .material = {}});
  scene.objects[1].is_movable = is_movable;
  if (moves) {
    scene.objects[0].motion = std::make_shared<const KeyframeMotion>(
        Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {1.0, Vec3::Zero(), Quat::Identity()}}, false);
  }
  return scene;
}

TEST(SceneMotion, GoesWithAProbeAndOtherObjects) {
  for (const bool has_tool : {false, true}) {
    EXPECT_TRUE(check_motion(moving_scene_with(false, false), has_tool));
    EXPECT_TRUE(check_motion(moving_scene_with(false, true), has_tool));
  }
  EXPECT_TRUE(check_motion(moving_scene_with(true, false), false));
}

TEST(SceneMotion, GoesWithAToolButNotBesideMovableObjects) {
  EXPECT_TRUE(check_motion(moving_scene_with(true, false), true));
  EXPECT_TRUE(check_motion(moving_scene_with(true, true), true)) << "a tool leaves movable objects where they are";
  EXPECT_EQ(check_motion(moving_scene_with(true, true), false).error().what,
            "object 'lid' moves by keyframes and 'peg' is movable, which cannot be combined: keep one of the two");
}

TEST(SceneMotion, WhatDeformsIsToldLikewise) {
  Scene scene = moving_scene_with(false, true);
  scene.objects[0].deformation = std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{{{0}, {Vec3::UnitX()}}},
                                                                         std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}}, false);
  EXPECT_EQ(check_motion(scene, true).error().what,
            "object 'lid' deforms, which a rigid tool does not support: leave out the tool, or the morphs");
  EXPECT_EQ(check_motion(scene, false).error().what,
            "object 'lid' deforms and 'peg' is movable, which cannot be combined: keep one of the two");
  scene.objects[1].is_movable = false;
  EXPECT_TRUE(check_motion(scene, false));
}

TEST(SceneMotion, WhatProgramsMoveIsToldLikewise) {
  Scene scene = moving_scene_with(false, true);
  ObjectSpec spec;
  spec.motion.by_program = true;
  scene.objects[0].commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), TriangleMesh());
  EXPECT_TRUE(check_motion(scene, true));
  EXPECT_EQ(check_motion(scene, false).error().what,
            "object 'lid' is moved by programs and 'peg' is movable, which cannot be combined: keep one of the two");
  scene.objects[1].is_movable = false;
  EXPECT_TRUE(check_motion(scene, false));
}

TEST(SceneMotion, WhatCanBeCarvedGoesWithAProbeOnly) {
  Scene scene = moving_scene_with(false, false);
  EXPECT_TRUE(check_sculpt(scene, true));
  scene.objects[0].sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1};
  EXPECT_TRUE(check_sculpt(scene, false));
  EXPECT_EQ(check_sculpt(scene, true).error().what,
            "object 'lid' can be carved, which a rigid tool does not support: leave out the tool, or 'sculpt'");
  scene.objects[1].is_movable = true;
  EXPECT_EQ(check_sculpt(scene, false).error().what,
            "object 'lid' can be carved and 'peg' is movable, which cannot be combined: keep one of the two");
}

}  // namespace
}  // namespace hapton
