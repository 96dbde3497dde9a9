#include "haptic_step/scene_change.h"

#include <gtest/gtest.h>

#include <memory>

#include "haptic_step/material_tuning.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

struct SceneChanges : testing::Test {
  SceneChanges() { folder.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n"); }

  Scene scene(const std::string& object, const std::string& material) {
    auto loaded =
        load_scene(folder.write("a.toml", "[[object]]\nmesh = 'a.obj'\nmaterial = 'm'\n" + object + "\n[material.m]\n" + material + "\n"));
    EXPECT_TRUE(loaded) << loaded.error().what;
    return *loaded;
  }

  ScratchFolder folder;
};

TEST_F(SceneChanges, AreDistinguished) {
  const Scene before = scene("", "stiffness_n_per_m = 500");
  EXPECT_EQ(compare_scenes(before, scene("color = [1, 0, 0]", "stiffness_n_per_m = 500")), SceneChange::none);
  for (const char* line :
       {"stiffness_n_per_m = 600", "stiffness_n_per_m = 500\ndamping_ns_per_m = 1", "stiffness_n_per_m = 500\nfriction_static = 0.1",
        "stiffness_n_per_m = 500\nfriction_static = 0.1\nfriction_dynamic = 0.1"}) {
    EXPECT_EQ(compare_scenes(before, scene("", line)), SceneChange::materials) << line;
  }
  for (const char* line : {"stiffness_n_per_m = 500\nviscosity_ns_per_m = 1", "stiffness_n_per_m = 600\nviscosity_ns_per_m = 1",
                           "stiffness_n_per_m = 500\n[[effect]]\ntype = 'spring'\nposition_m = [0, 0, 0]"}) {
    EXPECT_EQ(compare_scenes(before, scene("", line)), SceneChange::effects) << line;
  }
  EXPECT_EQ(compare_scenes(before, scene("name = 'other'", "stiffness_n_per_m = 500")), SceneChange::names);
  EXPECT_EQ(compare_scenes(before, scene("name = 'other'", "stiffness_n_per_m = 600")), SceneChange::effects);
  EXPECT_EQ(compare_scenes(before, scene("position_m = [0, 0, 0.01]", "stiffness_n_per_m = 500")), SceneChange::shape);
  const std::string deforms = "[[object.morph]]\npush_m = [0, 0, 0.01]\nkeys = [[0, 0], [1, ";
  const Scene deforming = scene(deforms + "1]]", "stiffness_n_per_m = 500");
  EXPECT_EQ(compare_scenes(before, deforming), SceneChange::shape);
  EXPECT_EQ(compare_scenes(deforming, scene(deforms + "1]]", "stiffness_n_per_m = 500")), SceneChange::none);
  EXPECT_EQ(compare_scenes(deforming, scene(deforms + "0.9]]", "stiffness_n_per_m = 500")), SceneChange::shape);
  const std::string moves = "[[object.keyframe]]\ntime_s = 0\n[[object.keyframe]]\ntime_s = ";
  const Scene moving = scene(moves + "1", "stiffness_n_per_m = 500");
  EXPECT_EQ(compare_scenes(before, moving), SceneChange::shape);
  EXPECT_EQ(compare_scenes(moving, before), SceneChange::shape);
  EXPECT_EQ(compare_scenes(moving, scene(moves + "2", "stiffness_n_per_m = 500")), SceneChange::shape);
  EXPECT_EQ(compare_scenes(moving, scene(moves + "1", "stiffness_n_per_m = 500")), SceneChange::none);
  const Scene commanded = scene("moved_by = 'program'", "stiffness_n_per_m = 500");
  EXPECT_EQ(compare_scenes(before, commanded), SceneChange::shape);
  EXPECT_EQ(compare_scenes(commanded, before), SceneChange::shape);
  EXPECT_EQ(compare_scenes(commanded, scene("moved_by = 'program'", "stiffness_n_per_m = 500")), SceneChange::none);
  EXPECT_EQ(compare_scenes(commanded, scene("moved_by = 'program'\npivot_m = [0.1, 0, 0]", "stiffness_n_per_m = 500")), SceneChange::shape);
  Scene carved = before, finer = before;
  carved.objects[0].sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1};
  finer.objects[0].sculpt = SculptSettings{.voxel_m = 0.0009, .tool_radius_m = 0.004, .button = 1};
  EXPECT_EQ(compare_scenes(before, carved), SceneChange::shape);
  EXPECT_EQ(compare_scenes(carved, carved), SceneChange::none);
  EXPECT_EQ(compare_scenes(carved, finer), SceneChange::shape);
  EXPECT_EQ(compare_scenes(before, scene("", "stiffness_n_per_m = 500\ntwo_sided = false")), SceneChange::shape);
  Scene streamed = before, alike = before, farther = before;
  streamed.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.01});
  alike.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.01});
  farther.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.02});
  EXPECT_EQ(compare_scenes(before, streamed), SceneChange::shape);
  EXPECT_EQ(compare_scenes(streamed, before), SceneChange::shape);
  EXPECT_EQ(compare_scenes(streamed, alike), SceneChange::none);
  EXPECT_EQ(compare_scenes(streamed, farther), SceneChange::shape);
  EXPECT_EQ(compare_scenes(before, scene("[[object]]\nmesh = 'a.obj'", "stiffness_n_per_m = 500")), SceneChange::shape);
}

// The state, applied to the scene before the change, gives the materials of the scene after it: recordings replay in this way.
TEST_F(SceneChanges, OfMaterialsAreDescribedByAStateForTheSceneBefore) {
  const Scene before = scene("[[object]]\nmesh = 'a.obj'", "stiffness_n_per_m = 500");
  const Scene after = scene("[[object]]\nmesh = 'a.obj'", "stiffness_n_per_m = 700\nfriction_static = 0.2");
  const auto state = describe_materials(before, after);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->object_count, 1U);
  const auto materials = tuned_materials(before.touch_scene(), *state, 0.0);
  ASSERT_EQ(materials.size(), 2U);
  EXPECT_EQ(materials[0].stiffness_n_per_m, 700.0);
  EXPECT_EQ(materials[0].friction_static, 0.2);
  EXPECT_EQ(materials[1].stiffness_n_per_m, before.objects[1].material.stiffness_n_per_m);
  EXPECT_EQ(describe_materials(after, after)->object_count, 0U);
}

TEST_F(SceneChanges, MoreMaterialsThanAStateHoldsAreNotDescribed) {
  Scene before;
  Scene after;
  for (std::size_t n = 0; n <= MaterialState::kMaxObjects; ++n) {
    before.objects.push_back({.name = "o", .mesh = std::make_shared<const TriangleMesh>(), .material = {}});
    after.objects.push_back({.name = "o", .mesh = std::make_shared<const TriangleMesh>(), .material = {.stiffness_n_per_m = 1.0}});
  }
  EXPECT_FALSE(describe_materials(before, after));
  before.objects.pop_back();
  after.objects.pop_back();
  EXPECT_TRUE(describe_materials(before, after));
}

}  // namespace
}  // namespace hapton
