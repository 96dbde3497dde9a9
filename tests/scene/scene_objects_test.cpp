#include "scene/scene_objects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace hapton {
namespace {

using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr std::array<std::string_view, 2> kKnown = {"rubber", "steel"};

Result<std::vector<ObjectSpec>> read_objects_of(const std::string& text) {
  const auto table = parse_toml(text);
  EXPECT_TRUE(table) << text;
  return read_scene_objects(*table, kKnown);
}

std::string objects_error(const std::string& text) {
  const auto read = read_objects_of(text);
  return read ? "it was read" : read.error().what;
}

const std::string kObject = "[[object]]\nmesh = 'a.obj'\n";

TEST(SceneObjects, WithoutGroupsAreThoseOfTheFile) {
  const auto read = read_objects_of(kObject + kObject + "scale = 2\n");
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_THAT(*read, SizeIs(2));
  EXPECT_EQ((*read)[0].name, "");
  EXPECT_EQ((*read)[1].scale, 2.0);
}

TEST(SceneObjects, GroupsAndInstancesMayStandBeforeWhatTheyName) {
  const auto read = read_objects_of("[[instance]]\nname = 'b'\nof = 'a'\n[[group]]\nname = 'g'\n" + kObject + kObject + "group = 'g'\n");
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_THAT(*read, SizeIs(3));
  EXPECT_EQ((*read)[1].name, "b");
  EXPECT_EQ((*read)[2].name, "g/a");
}

TEST(SceneObjects, NeedTheirMaterials) {
  EXPECT_THAT(objects_error(kObject + "material = 'stel'\n"), StartsWith("line 3: there is no [material.stel]; did you mean 'steel'?"));
  const std::string in_group = kObject + "material = 'steel'\ngroup = 'g'\n";
  EXPECT_THAT(objects_error(in_group + "[[group]]\nname = 'g'\nmaterial = 'rubbr'\n"),
              StartsWith("line 7: there is no [material.rubbr]; did you mean 'rubber'?"));
  EXPECT_THAT(objects_error(kObject + "[[instance]]\nname = 'b'\nof = 'a'\nmaterial = 'x'\n"),
              StartsWith("line 6: there is no [material.x]"));
}

TEST(SceneObjects, AGroupAloneIsNoScene) {
  EXPECT_EQ(objects_error("[[group]]\nname = 'g'\n"), "there is no [[object]]: add one with its mesh");
}

}  // namespace
}  // namespace hapton
