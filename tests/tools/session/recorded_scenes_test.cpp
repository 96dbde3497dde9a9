#include "tools/session/recorded_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "haptic_step/haptics_setup.h"
#include "scene/scene_hash.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

struct RecordedScenesTest : testing::Test {
  RecordedScenesTest() {
    scratch.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
    scene = scratch.write("a.toml", "[[object]]\nmesh = 'a.obj'\nname = 'hood'\nmaterial = 'tin'\n[material.tin]\n");
  }
  HapticsSetup setup() const { return make_haptics_setup(scene, {}, hash_scene(load_scene(scene)->touch_scene()), MethodSettings()); }
  ScratchFolder scratch;
  std::filesystem::path scene;
};

TEST_F(RecordedScenesTest, GiveTheNamesOfTheSceneThatWasRecorded) {
  RecordedScenes scenes;
  const auto names = scenes.find_names(setup());
  ASSERT_TRUE(names) << names.error().what;
  EXPECT_EQ(describe_object(*names, 0), "hood (tin)");
  EXPECT_TRUE(scenes.make_touch(setup()));
  EXPECT_EQ(scenes.make_materials(setup(), {})->size(), 1U);
}

TEST_F(RecordedScenesTest, AnotherSceneOfThatNameIsRejected) {
  const HapticsSetup before = setup();
  scratch.write("a.toml", "[[object]]\nmesh = 'a.obj'\n[[object]]\nmesh = 'a.obj'\n");
  const auto names = RecordedScenes().find_names(before);
  ASSERT_FALSE(names);
  EXPECT_THAT(names.error().what, HasSubstr("is not the scene that was recorded"));
  std::filesystem::remove(scene);
  EXPECT_THAT(RecordedScenes().find_names(before).error().what, HasSubstr("give its present place with --scene FILE"));
}

}  // namespace
}  // namespace hapton
