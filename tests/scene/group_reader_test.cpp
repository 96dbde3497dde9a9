#include "scene/group_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

Result<std::vector<GroupSpec>> read_groups_and_instances(const std::string& text) {
  const auto table = parse_toml(text);
  EXPECT_TRUE(table) << text;
  auto groups = read_groups(*table);
  if (!groups) return groups;
  auto instances = read_instances(*table);
  if (instances) groups->insert(groups->end(), instances->begin(), instances->end());
  return instances ? groups : instances;
}

std::string group_error(const std::string& text) {
  const auto read = read_groups_and_instances(text);
  return read ? "it was read" : read.error().what;
}

TEST(GroupReader, ReadsEveryKey) {
  const auto read = read_groups_and_instances(R"(
[[group]]
name = "left"
group = "car"
position_m = [1, 2, 3]
rotation_deg = [0, 0, 90]
scale = 2
material = "rubber"
color = [0.1, 0.2, 0.3]
[[instance]]
name = "right"
of = "left"
group = "car"
position_m = [3, 2, 1]
rotation = [0, 0, 1, 0]
scale = 0.5
material = "steel"
color = [0.3, 0.2, 0.1]
)");
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_THAT(*read, SizeIs(2));
  const GroupSpec& group = (*read)[0];
  EXPECT_EQ(group.name, "left");
  EXPECT_EQ(group.group, "car");
  EXPECT_EQ(*group.p, Vec3(1, 2, 3));
  EXPECT_LT((*group.q * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-12);
  EXPECT_EQ(*group.scale, 2.0);
  EXPECT_EQ(group.material, "rubber");
  EXPECT_EQ(*group.colour, (std::array<double, 3>{0.1, 0.2, 0.3}));
  EXPECT_EQ(group.line, 2U);
  EXPECT_EQ(group.group_line, 4U);
  EXPECT_EQ(group.material_line, 8U);
  const GroupSpec& instance = (*read)[1];
  EXPECT_EQ(instance.name, "right");
  EXPECT_EQ(instance.of, "left");
  EXPECT_EQ(instance.of_line, 12U);
  EXPECT_EQ(*instance.p, Vec3(3, 2, 1));
  EXPECT_LT((*instance.q * Vec3::UnitX() + Vec3::UnitX()).norm(), 1e-12);
  EXPECT_EQ(*instance.scale, 0.5);
}

TEST(GroupReader, LeavesOutWhatIsNotGiven) {
  const auto read = read_groups_and_instances("[[instance]]\nname = 'b'\nof = 'a'\n");
  ASSERT_TRUE(read) << read.error().what;
  const GroupSpec& instance = read->at(0);
  EXPECT_FALSE(instance.p || instance.q || instance.scale || instance.colour);
  EXPECT_THAT(instance.material, IsEmpty());
  EXPECT_THAT(*read_groups_and_instances("fit_m = 1\n"), IsEmpty());
}

TEST(GroupReader, NamesLineKeyAndWhatIsAllowed) {
  const std::string group = "[[group]]\nname = 'g'\n";
  EXPECT_THAT(group_error("group = 1\n"), StartsWith("line 1: 'group' must be tables that begin with [[group]]"));
  EXPECT_THAT(group_error("[group]\nname = 'g'\n"), HasSubstr("'group' must be tables that begin with [[group]]"));
  EXPECT_THAT(group_error("instance = [1]\n"), StartsWith("line 1: 'instance' must be tables that begin with [[instance]]"));
  EXPECT_THAT(group_error("[[group]]\nscale = 1\n"), StartsWith("line 1: [[group]] 1 has no 'name': add it"));
  EXPECT_THAT(group_error("[[group]]\nname = ''\n"), StartsWith("line 2: 'name' in [[group]] 1 has 0 bytes: give 1 to 60"));
  EXPECT_THAT(group_error("[[group]]\nname = '" + std::string(61, 'g') + "'\n"), HasSubstr("has 61 bytes"));
  EXPECT_EQ(group_error("[[group]]\nname = '" + std::string(60, 'g') + "'\n"), "it was read");
  EXPECT_THAT(group_error("[[group]]\nname = 'a/b'\n"), StartsWith("line 2: 'name' in [[group]] 1 is 'a/b': it may not contain '/'"));
  EXPECT_THAT(group_error("[[instance]]\nname = 'i'\n"), StartsWith("line 1: [[instance]] 1 has no 'of': add it"));
  EXPECT_THAT(group_error("[[instance]]\nof = 'i'\n"), StartsWith("line 1: [[instance]] 1 has no 'name': add it"));
  EXPECT_THAT(group_error("[[instance]]\nname = 'i'\nof = 5\n"), StartsWith("line 3: 'of' in [[instance]] 1 must be a text in quotes"));
  EXPECT_THAT(group_error(group + "of = 'x'\n"), StartsWith("line 3: unknown key 'of' in [[group]] 1"));
  EXPECT_THAT(group_error(group + "positon_m = [0, 0, 0]\n"),
              HasSubstr("line 3: unknown key 'positon_m' in [[group]] 1; did you mean 'position_m'?"));
  EXPECT_THAT(group_error(group + "position_m = [0, 0]\n"), HasSubstr("'position_m' in [[group]] 1 must be a list of 3 numbers"));
  EXPECT_THAT(group_error(group + "position_m = [0, 2e6, 0]\n"),
              HasSubstr("number 2 of 'position_m' in [[group]] 1 is 2000000: it must be"));
  EXPECT_THAT(group_error(group + "scale = 0\n"), StartsWith("line 3: 'scale' in [[group]] 1 is 0: it must be above 0"));
  EXPECT_THAT(group_error(group + "scale = 1e-300\n"), StartsWith("line 3: 'scale' in [[group]] 1 is 1e-300: it must be at least 1e-09"));
  EXPECT_THAT(group_error("[[group]]\nname = \"a\\u001b[2J\"\n"),
              StartsWith("line 2: 'name' in [[group]] 1 is 'a?[2J', with a control character"));
  EXPECT_THAT(group_error("[[group]]\nname = \"a\\u0000b\"\n"), HasSubstr("with a control character: leave it out"));
  EXPECT_THAT(group_error(group + "rotation_deg = [0, 0, 400]\n"), HasSubstr("at least -360 and at most 360"));
  EXPECT_THAT(group_error(group + "rotation_deg = [0, 0, 0]\nrotation = [1, 0, 0, 0]\n"), HasSubstr("keep one"));
  EXPECT_THAT(group_error(group + "color = [0, 0, 2]\n"),
              HasSubstr("number 3 of 'color' in [[group]] 1 is 2: it must be at least 0 and at most 1"));
}

}  // namespace
}  // namespace hapton
