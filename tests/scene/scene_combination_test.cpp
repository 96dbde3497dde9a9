#include "scene/scene_combination.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "core/tool/tool_step.h"
#include "scene/object_reader.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

constexpr const char* kFile = "room.toml";

Scene make_lid_and_peg(bool moves, bool is_movable) {
  Scene scene;
  scene.objects.push_back({.name = "lid", .mesh = nullptr, .material = {}, .line = 2});
  scene.objects.push_back({.name = "peg", .mesh = nullptr, .material = {}, .line = 7});
  scene.objects[1].is_movable = is_movable;
  if (moves) {
    scene.objects[0].motion = std::make_shared<const KeyframeMotion>(
        Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {1.0, Vec3::Zero(), Quat::Identity()}}, false);
  }
  return scene;
}

TEST(SceneCombination, GoesWithAProbeAndOtherObjects) {
  for (const bool has_tool : {false, true}) {
    EXPECT_TRUE(check_combination(kFile, make_lid_and_peg(false, false), has_tool));
    EXPECT_TRUE(check_combination(kFile, make_lid_and_peg(false, true), has_tool));
  }
  EXPECT_TRUE(check_combination(kFile, make_lid_and_peg(true, false), false));
}

TEST(SceneCombination, WhatMovesGoesWithAToolAndBesideMovableObjects) {
  EXPECT_TRUE(check_combination(kFile, make_lid_and_peg(true, false), true));
  EXPECT_TRUE(check_combination(kFile, make_lid_and_peg(true, true), true)) << "a tool leaves movable objects where they are";
  EXPECT_TRUE(check_combination(kFile, make_lid_and_peg(true, true), false));
}

TEST(SceneCombination, DeformingObjectsAreRejectedWithToolsAndMovableObjects) {
  Scene scene = make_lid_and_peg(false, true);
  scene.objects[0].deformation = std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{{{0}, {Vec3::UnitX()}}},
                                                                         std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}}, false);
  EXPECT_EQ(check_combination(kFile, scene, true).error().what,
            "room.toml: line 2: object 'lid' deforms, which a rigid tool does not support: leave out the tool, or the morphs");
  EXPECT_EQ(check_combination(kFile, scene, false).error().what,
            "room.toml: line 2: object 'lid' deforms and 'peg' (line 7) is movable, which cannot be combined: keep one of the two");
  scene.objects[1].is_movable = false;
  EXPECT_TRUE(check_combination(kFile, scene, false));
}

TEST(SceneCombination, WhatProgramsMoveGoesWithAToolAndBesideMovableObjects) {
  Scene scene = make_lid_and_peg(false, true);
  ObjectSpec spec;
  spec.motion.by_program = true;
  scene.objects[0].commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), TriangleMesh());
  EXPECT_TRUE(check_combination(kFile, scene, true));
  EXPECT_TRUE(check_combination(kFile, scene, false));
  scene.objects[1].is_movable = false;
  EXPECT_TRUE(check_combination(kFile, scene, false));
}

TEST(SceneCombination, ObjectsThatProgramsDeformAreRejectedLikewise) {
  Scene scene = make_lid_and_peg(false, true);
  scene.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.01});
  EXPECT_EQ(check_combination(kFile, scene, true).error().what,
            "room.toml: line 2: object 'lid' deforms, which a rigid tool does not support: leave out the tool, or 'deformed_by'");
  EXPECT_EQ(
      check_combination(kFile, scene, false).error().what,
      "room.toml: line 2: object 'lid' is deformed by programs and 'peg' (line 7) is movable, which cannot be combined: keep one of the "
      "two");
  scene.objects[1].is_movable = false;
  EXPECT_TRUE(check_combination(kFile, scene, false));
  for (std::size_t n = 0; n < ProgramShape::kMaxObjects; ++n) scene.objects.push_back(scene.objects[0]);
  EXPECT_EQ(check_combination(kFile, scene, false).error().what,
            "room.toml: line 2: object 'lid' exceeds the limit of 8 objects that programs deform");
}

TEST(SceneCombination, WhatCanBeCarvedGoesWithAProbeOnly) {
  Scene scene = make_lid_and_peg(false, false);
  EXPECT_TRUE(check_combination(kFile, scene, true));
  scene.objects[0].sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1};
  EXPECT_TRUE(check_combination(kFile, scene, false));
  EXPECT_EQ(check_combination(kFile, scene, true).error().what,
            "room.toml: line 2: object 'lid' can be carved, which a rigid tool does not support: leave out the tool, or 'sculpt'");
  scene.objects[1].is_movable = true;
  EXPECT_EQ(check_combination(kFile, scene, false).error().what,
            "room.toml: line 2: object 'lid' can be carved and 'peg' (line 7) is movable, which cannot be combined: keep one of the two");
}

TEST(SceneCombination, AnObjectThatMovesByItselfIsNotMovable) {
  Scene scene = make_lid_and_peg(true, false);
  scene.objects[0].is_movable = true;
  EXPECT_EQ(check_combination(kFile, scene, false).error().what,
            "room.toml: line 2: object 'lid' moves by keyframes and is movable, which cannot be combined: keep one of the two");
}

TEST(SceneCombination, AMovableObjectTouchesAsManyPartsThatMoveAsAToolDoes) {
  Scene scene = make_lid_and_peg(false, true);
  const auto add_lid_by_program = [&] {
    ObjectSpec spec;
    spec.motion.by_program = true;
    scene.objects.push_back(scene.objects[0]);
    scene.objects.back().commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), TriangleMesh());
  };
  for (int n = 0; n < ToolStep::kMaxParts; ++n) add_lid_by_program();
  EXPECT_TRUE(check_combination(kFile, scene, false));
  add_lid_by_program();
  EXPECT_EQ(check_combination(kFile, scene, false).error().what,
            "room.toml: line 7: object 'peg' is movable, and 33 parts of the scene move by themselves: 32 at most beside a movable object; "
            "let some stand still, or move together");
}

TEST(SceneCombination, NoLineIsNamedWhereNoneIsKnown) {
  Scene scene = make_lid_and_peg(false, true);
  scene.objects[0].sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1};
  for (SceneObject& object : scene.objects) object.line = 0;
  EXPECT_EQ(check_combination(kFile, scene, false).error().what,
            "room.toml: object 'lid' can be carved and 'peg' is movable, which cannot be combined: keep one of the two");
}

TEST(SceneCombination, LinesTellObjectsOfOneNameApart) {
  const ScratchFolder folder;
  folder.write("ball.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const auto path =
      folder.write("room.toml", "[[object]]\nmesh = 'ball.obj'\nsculpt = true\n[[object]]\nmesh = 'ball.obj'\nmovable = true\n");
  const auto scene = load_scene(path);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(check_combination(path, *scene, false).error().what,
            path.string() +
                ": line 2: object 'ball' can be carved and 'ball' (line 5) is movable, which cannot be combined: keep one of the two");
}

}  // namespace
}  // namespace hapton
