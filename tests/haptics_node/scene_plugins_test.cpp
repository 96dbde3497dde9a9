#include "haptics_node/scene_plugins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

using ::testing::HasSubstr;

Scene scene_with(const std::string& value) {
  Scene scene;
  scene.libraries.push_back({.name = "odd", .library = "/x/odd.so", .parameters = {{"n", value}}, .line = 7});
  return scene;
}

TEST(ScenePlugins, AreChosenOnlyWhereThePersonSaysSo) {
  const auto rejected = choose_scene_plugins(scene_with("1"), "a.toml", false);
  ASSERT_FALSE(rejected);
  EXPECT_EQ(
      rejected.error().what,
      "a.toml: line 7: effect odd would run the code of /x/odd.so: give --allow-plugins if you trust it, or take it out of the scene");
  const auto chosen = choose_scene_plugins(scene_with("1"), "a.toml", true);
  ASSERT_TRUE(chosen);
  ASSERT_EQ(chosen->size(), 1U);
  EXPECT_EQ(chosen->front().to_text(), "/x/odd.so:n=1");
  EXPECT_TRUE(choose_scene_plugins(Scene(), "a.toml", false)) << "a scene without any";
}

TEST(ScenePlugins, AreComparedInOrder) {
  EXPECT_TRUE(has_same_plugins(scene_with("1"), scene_with("1")));
  EXPECT_FALSE(has_same_plugins(scene_with("1"), scene_with("2")));
  EXPECT_FALSE(has_same_plugins(scene_with("1"), Scene()));
  EXPECT_TRUE(has_same_plugins(Scene(), Scene()));
}

}  // namespace
}  // namespace hapton
