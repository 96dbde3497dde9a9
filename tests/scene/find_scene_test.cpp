#include "scene/find_scene.h"

#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

struct FindScene : testing::Test {
  FindScene() {
    std::filesystem::create_directories(bin);
    std::filesystem::create_directories(share / "scenes");
    scratch.write("share/hapton/scenes/a_scene_of_this_test.toml", "x");
    std::filesystem::create_directories(scratch.path() / "scenes");
    scratch.write("scenes/a_scene_of_this_test.toml", "x");
  }
  ScratchFolder scratch;
  std::filesystem::path bin = scratch.path() / "bin";
  std::filesystem::path share = scratch.path() / "share/hapton";
};

TEST_F(FindScene, IsInTheInstalledFolderWhenThereIsNoneHere) {
  EXPECT_EQ(find_scene("scenes/a_scene_of_this_test.toml", bin), share / "scenes/a_scene_of_this_test.toml");
}

TEST_F(FindScene, IsInTheSourceTreeOfABuild) {
  EXPECT_EQ(find_scene("scenes/a_scene_of_this_test.toml", scratch.path() / "build/release/bin"),
            scratch.path() / "scenes/a_scene_of_this_test.toml");
}

TEST_F(FindScene, HereComesFirst) {
  const auto relative = std::filesystem::relative(scratch.path() / "scenes/a_scene_of_this_test.toml");
  EXPECT_EQ(find_scene(relative, bin), relative);
}

TEST_F(FindScene, WhatIsNowhereOrAbsoluteStaysAsItWasNamed) {
  EXPECT_EQ(find_scene("scenes/none.toml", bin), "scenes/none.toml");
  EXPECT_EQ(find_scene("/scenes/a_scene_of_this_test.toml", bin), "/scenes/a_scene_of_this_test.toml");
  EXPECT_EQ(find_scene("scenes/none_at_all.toml"), "scenes/none_at_all.toml");
}

}  // namespace
}  // namespace hapton
