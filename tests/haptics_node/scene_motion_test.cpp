#include "haptics_node/scene_motion.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

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

TEST(SceneMotion, DoesNotGoWithAToolOrMovableObjects) {
  EXPECT_EQ(check_motion(moving_scene_with(true, false), true).error().what,
            "object 'lid' moves by keyframes, which a rigid tool does not feel yet: leave out the tool, or the keyframes");
  EXPECT_EQ(check_motion(moving_scene_with(true, true), false).error().what,
            "object 'lid' moves by keyframes and 'peg' is movable, which do not go together yet: keep one of the two");
}

}  // namespace
}  // namespace hapton
