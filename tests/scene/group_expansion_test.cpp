#include "scene/group_expansion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "scene/scene_file.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr double kRounding = 1e-12;

class GroupedScene : public ::testing::Test {
 protected:
  GroupedScene() { folder_.write("a.obj", sample::obj(sample::tetrahedron())); }

  Result<Scene> load(const std::string& text) { return load_scene(folder_.write("s.toml", text)); }

  // Both files make the same scene: equal names, materials and colours, and equal geometry up to rounding.
  void expect_same(const std::string& grouped_text, const std::string& plain_text) {
    const auto grouped = load(grouped_text);
    const auto plain = load(plain_text);
    ASSERT_TRUE(grouped) << grouped.error().what;
    ASSERT_TRUE(plain) << plain.error().what;
    ASSERT_EQ(grouped->objects.size(), plain->objects.size());
    for (std::size_t o = 0; o < grouped->objects.size(); ++o) {
      const SceneObject& object = grouped->objects[o];
      const SceneObject& expected = plain->objects[o];
      EXPECT_EQ(object.name, expected.name);
      EXPECT_EQ(object.material_name, expected.material_name) << object.name;
      EXPECT_EQ(object.colour, expected.colour) << object.name;
      EXPECT_EQ(object.is_movable, expected.is_movable) << object.name;
      EXPECT_EQ(object.mesh->triangles, expected.mesh->triangles) << object.name;
      ASSERT_EQ(object.mesh->vertices.size(), expected.mesh->vertices.size());
      for (std::size_t v = 0; v < object.mesh->vertices.size(); ++v) {
        EXPECT_LT((object.mesh->vertices[v] - expected.mesh->vertices[v]).norm(), kRounding) << object.name;
      }
    }
  }

  std::string error_of(const std::string& text) {
    const auto scene = load(text);
    return scene ? "it was read" : scene.error().what.substr(scene.error().what.find(": ") + 2);
  }

  std::vector<std::string> names_of(const std::string& text) {
    const auto scene = load(text);
    EXPECT_TRUE(scene) << scene.error().what;
    std::vector<std::string> names;
    if (scene) {
      for (const SceneObject& object : scene->objects) names.push_back(object.name);
    }
    return names;
  }

  ScratchFolder folder_;
};

const std::string kMaterials = "[material.soft]\nstiffness_n_per_m = 100\n[material.hard]\nstiffness_n_per_m = 900\n";

TEST_F(GroupedScene, PlacesObjectsByThePosesOfTheirGroups) {
  // Outer group: moved by (1, 0, 0), turned by 90 degrees about z, scaled by 2. Inner: moved by (0, 0, 1), turned by 90 about x, halved.
  expect_same(R"(
[[group]]
name = "outer"
position_m = [1, 0, 0]
rotation_deg = [0, 0, 90]
scale = 2
[[group]]
name = "inner"
group = "outer"
position_m = [0, 0, 1]
rotation_deg = [90, 0, 0]
scale = 0.5
[[object]]
mesh = "a.obj"
name = "one"
group = "inner"
position_m = [0, 1, 0]
scale = 3
[[object]]
mesh = "a.obj"
group = "outer"
position_m = [0, 1, 0]
)",
              // (0, 1, 0) of the inner group is (0, 0, 0.5) + (0, 0, 1) in the outer group, which is (1, 0, 3) in the scene.
              R"(
[[object]]
mesh = "a.obj"
name = "outer/a"
position_m = [-1, 0, 0]
rotation_deg = [0, 0, 90]
scale = 2
[[object]]
mesh = "a.obj"
name = "outer/inner/one"
position_m = [1, 0, 3]
rotation_deg = [90, 0, 90]
scale = 3
)");
}

TEST_F(GroupedScene, AGroupThatLeavesAllAsItIsKeepsEveryBit) {
  const std::string object = "[[object]]\nmesh = 'a.obj'\nposition_m = [0.1, 0.2, 0.3]\nrotation_deg = [10, 20, 30]\nscale = 0.7\n";
  const auto plain = load(object);
  const auto grouped = load("[[group]]\nname = 'g'\n" + object + "group = 'g'\n");
  ASSERT_TRUE(plain && grouped);
  EXPECT_EQ(plain->given_hash, grouped->given_hash);
}

TEST_F(GroupedScene, AnInstanceOfAnObjectHasItsValuesUnlessItGivesOthers) {
  expect_same(kMaterials + R"(
[[object]]
mesh = "a.obj"
name = "peg"
position_m = [1, 0, 0]
rotation_deg = [0, 0, 90]
scale = 2
material = "soft"
color = [0.1, 0.2, 0.3]
movable = true
[[instance]]
name = "moved"
of = "peg"
position_m = [5, 6, 7]
[[instance]]
name = "other"
of = "peg"
rotation_deg = [90, 0, 0]
scale = 3
material = "hard"
color = [0.3, 0.2, 0.1]
)",
              kMaterials + R"(
[[object]]
mesh = "a.obj"
name = "peg"
position_m = [1, 0, 0]
rotation_deg = [0, 0, 90]
scale = 2
material = "soft"
color = [0.1, 0.2, 0.3]
movable = true
[[object]]
mesh = "a.obj"
name = "moved"
position_m = [5, 6, 7]
rotation_deg = [0, 0, 90]
scale = 2
material = "soft"
color = [0.1, 0.2, 0.3]
movable = true
[[object]]
mesh = "a.obj"
name = "other"
position_m = [1, 0, 0]
rotation_deg = [90, 0, 0]
scale = 3
material = "hard"
color = [0.3, 0.2, 0.1]
movable = true
)");
}

TEST_F(GroupedScene, AnInstanceOfAGroupPlacesAllOfItAgain) {
  expect_same(kMaterials + R"(
[[group]]
name = "axle"
position_m = [0, 0, 1]
material = "soft"
color = [0.1, 0.1, 0.1]
[[object]]
mesh = "a.obj"
name = "left"
group = "axle"
position_m = [-1, 0, 0]
[[instance]]
name = "right"
of = "axle/left"
group = "axle"
position_m = [1, 0, 0]
material = "hard"
[[instance]]
name = "rear axle"
of = "axle"
position_m = [0, 0, -1]
color = [0.5, 0.5, 0.5]
)",
              kMaterials + R"(
[[object]]
mesh = "a.obj"
name = "rear axle/left"
position_m = [-1, 0, -1]
material = "soft"
color = [0.5, 0.5, 0.5]
[[object]]
mesh = "a.obj"
name = "rear axle/right"
position_m = [1, 0, -1]
material = "hard"
color = [0.5, 0.5, 0.5]
[[object]]
mesh = "a.obj"
name = "axle/left"
position_m = [-1, 0, 1]
material = "soft"
color = [0.1, 0.1, 0.1]
[[object]]
mesh = "a.obj"
name = "axle/right"
position_m = [1, 0, 1]
material = "hard"
color = [0.1, 0.1, 0.1]
)");
}

TEST_F(GroupedScene, TheInnermostMaterialAndColourCount) {
  const auto scene = load(kMaterials + R"(
[[group]]
name = "outer"
material = "soft"
color = [1, 0, 0]
[[group]]
name = "inner"
group = "outer"
material = "hard"
[[object]]
mesh = "a.obj"
name = "one"
group = "inner"
[[object]]
mesh = "a.obj"
name = "two"
group = "inner"
material = "soft"
color = [0, 1, 0]
)");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->objects[0].material_name, "hard");
  EXPECT_EQ(scene->objects[0].colour, (std::array<double, 3>{1, 0, 0}));
  EXPECT_EQ(scene->objects[1].material_name, "soft");
  EXPECT_EQ(scene->objects[1].colour, (std::array<double, 3>{0, 1, 0}));
}

// An instance moves as its object does: relative to its own pose, its motion is that of the object relative to the object's pose.
TEST_F(GroupedScene, KeyframesFollowTheGroupAndTheInstance) {
  const auto scene = load(R"(
[[group]]
name = "g"
position_m = [0, 5, 0]
rotation_deg = [0, 90, 0]
[[object]]
mesh = "a.obj"
name = "lid"
position_m = [0.1, 0, 0]
scale = 0.1
group = "g"
[[object.keyframe]]
time_s = 0
[[object.keyframe]]
time_s = 100
position_m = [0.1, 0.2, 0]
rotation_deg = [0, 0, 80]
[[instance]]
name = "second"
of = "g/lid"
position_m = [0.4, 0, 0]
rotation_deg = [90, 0, 0]
scale = 0.2
)");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_THAT(scene->objects, SizeIs(2));
  const Vec3 in_mesh(1.5, 0, 0);  // vertex 1
  const Vec3 turned_in_mesh = Eigen::AngleAxisd(80.0 * M_PI / 180.0, Vec3::UnitZ()) * in_mesh;
  const Quat instance_rotation(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));
  // The object moves from (0.1, 0, 0) by (0, 0.2, 0); the instance is twice as large, turned, and begins at (0.4, 0, 0).
  const Vec3 expected_second = Vec3(0.4, 0, 0) + instance_rotation * (2.0 * Vec3(0, 0.2, 0) + 0.2 * turned_in_mesh);
  const SceneObject& second = scene->objects[0];
  EXPECT_EQ(second.name, "second");
  EXPECT_LT((second.motion->pose_at(100.0) * second.mesh->vertices[1] - expected_second).norm(), 1e-9);
  const SceneObject& lid = scene->objects[1];
  const Vec3 in_group = Vec3(0.1, 0.2, 0) + 0.1 * turned_in_mesh;
  const Vec3 expected_lid = Vec3(0, 5, 0) + Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()) * in_group;
  EXPECT_LT((lid.motion->pose_at(100.0) * lid.mesh->vertices[1] - expected_lid).norm(), 1e-9);
}

TEST_F(GroupedScene, WhatIsInNoGroupComesFirst) {
  EXPECT_THAT(names_of("[[group]]\nname = 'g'\n[[group]]\nname = 'h'\n[[group]]\nname = 'in'\ngroup = 'g'\n"
                       "[[object]]\nmesh = 'a.obj'\nname = '1'\ngroup = 'h'\n[[object]]\nmesh = 'a.obj'\nname = '2'\ngroup = 'in'\n"
                       "[[object]]\nmesh = 'a.obj'\nname = '3'\ngroup = 'g'\n[[object]]\nmesh = 'a.obj'\nname = '4'\n"
                       "[[instance]]\nname = '5'\nof = 'in'\n"),
              ElementsAre("4", "5/2", "g/3", "g/in/2", "h/1"));
}

TEST_F(GroupedScene, EffectsNameObjectsOfGroups) {
  const std::string text = "[[group]]\nname = 'g'\nposition_m = [1, 0, 0]\n[[object]]\nmesh = 'a.obj'\ngroup = 'g'\n";
  const std::string effect = "[[effect]]\ntype = 'gravity_well'\nradius_m = 0.01\nmax_force_n = 1.0\nobject = ";
  EXPECT_TRUE(load(text + effect + "'g/a'\n")) << load(text + effect + "'g/a'\n").error().what;
  EXPECT_THAT(error_of(text + effect + "'a'\n"), HasSubstr("there is no object named a"));
}

TEST_F(GroupedScene, NamesWhatIsWrong) {
  const std::string object = "[[object]]\nmesh = 'a.obj'\n";  // lines 1 and 2
  const std::string in_group = object + "group = 'g'\n[[group]]\nname = 'g'\n";
  EXPECT_EQ(error_of(object + "group = 'g'\n"), "line 3: there is no [[group]] named 'g': add it");
  EXPECT_EQ(error_of(object + "group = 'weels'\n[[group]]\nname = 'wheels'\n"),
            "line 3: there is no [[group]] named 'weels'; did you mean 'wheels'?");
  EXPECT_EQ(error_of(object + "group = 5\n"), "line 3: 'group' in [[object]] 1 must be a text in quotes");
  EXPECT_EQ(error_of(in_group + "group = 'h'\n"), "line 6: there is no [[group]] named 'h'; did you mean 'g'?");
  EXPECT_EQ(error_of(in_group + "group = 'g'\n"), "line 4: group 'g' is inside itself: g in g");
  EXPECT_EQ(error_of(in_group + "group = 'h'\n[[group]]\nname = 'h'\ngroup = 'g'\n"), "line 4: group 'g' is inside itself: g in h in g");
  EXPECT_EQ(error_of(in_group + "[[group]]\nname = 'g'\n"), "line 6: there are two groups named 'g': give each its own name");
  EXPECT_EQ(error_of(object + "[[group]]\nname = 'g'\n"),
            "line 3: group 'g' is empty: put objects into it with group = \"g\", or leave it out");
  EXPECT_EQ(error_of(in_group + "[[instance]]\nname = 'i'\nof = 'a'\n"),
            "line 8: there is no object or group named 'a'; did you mean 'g/a'?");
  EXPECT_THAT(error_of(in_group + "[[instance]]\nname = 'i'\nof = 'nothing'\n"),
              HasSubstr("line 8: there is no object or group named 'nothing'; known are g/a, g"));
  EXPECT_EQ(error_of(in_group + "[[instance]]\nname = 'i'\nof = 'g'\n[[instance]]\nname = 'k'\nof = 'i'\n"),
            "line 11: 'i' is an instance itself: name the object or the group that it shows");
  EXPECT_EQ(error_of(object + in_group + "[[object]]\nmesh = 'a.obj'\nname = 'g'\n[[instance]]\nname = 'i'\nof = 'g'\n"),
            "line 13: 'g' is the name of a group and of an object: give each its own");
  EXPECT_EQ(error_of(object + object + "[[instance]]\nname = 'i'\nof = 'a'\n"),
            "line 7: 'a' is the name of several objects: give each its own");
  EXPECT_EQ(error_of(in_group + "[[instance]]\nname = 'i'\nof = 'g'\ngroup = 'g'\n"),
            "line 8: instance 'g/i' is inside the group 'g' that it shows: it would contain itself");
  EXPECT_EQ(error_of(in_group + "[[instance]]\nname = 'g'\nof = 'g'\n"),
            "line 6: two objects have the name 'g/a': in a scene with groups or instances give each its own");
  EXPECT_EQ(error_of(object + "[[instance]]\nname = 'a'\nof = 'a'\n"),
            "line 3: two objects have the name 'a': in a scene with groups or instances give each its own");
  EXPECT_THAT(error_of(in_group + "scale = 1e9\n[[group]]\nname = 'h'\nscale = 1e9\ngroup = 'g'\n" + object + "group = 'h'\n"),
              HasSubstr("line 12: 'g/h/a' is 1e+18 times its size"));
  EXPECT_THAT(error_of(in_group + "position_m = [1e6, 0, 0]\n" + object + "name = 'b'\ngroup = 'g'\nposition_m = [1, 0, 0]\n"),
              HasSubstr("line 8: 'g/b' is 1 times its size, 1e+06 m from the origin"));
  EXPECT_EQ(error_of(object + "[tool]\nmesh = 'a.obj'\ngroup = 'g'\n").substr(0, 37), "line 5: unknown key 'group' in [tool]");
}

TEST_F(GroupedScene, BoundsDepthAndNumber) {
  const auto nested = [](int depth) {
    std::string text;
    for (int g = 0; g < depth; ++g) {
      text += fmt::format("[[group]]\nname = 'g{}'\n", g);
      if (g > 0) text += fmt::format("group = 'g{}'\n", g - 1);
    }
    return text + fmt::format("[[object]]\nmesh = 'a.obj'\ngroup = 'g{}'\n", depth - 1);
  };
  EXPECT_THAT(names_of(nested(16)), SizeIs(1));
  EXPECT_THAT(error_of(nested(17)), HasSubstr("group 'g16' is inside more than 15 others: use fewer"));
  // Each group shows the one before twice: 2^k objects.
  const auto doubled = [](int times) {
    std::string text = "[[object]]\nmesh = 'a.obj'\ngroup = 'g0'\n[[group]]\nname = 'g0'\n";
    for (int g = 1; g <= times; ++g) {
      text += fmt::format("[[group]]\nname = 'g{}'\n", g);
      for (const char* name : {"x", "y"}) text += fmt::format("[[instance]]\nname = '{}'\nof = 'g{}'\ngroup = 'g{}'\n", name, g - 1, g);
    }
    return text;
  };
  EXPECT_THAT(names_of(doubled(10)), SizeIs(2047));
  EXPECT_THAT(error_of(doubled(40)), HasSubstr("there are more than 4096 objects: use fewer instances"));
  // Each group shows the next one: a file can nest more levels than the stack of a recursive reader can hold.
  const auto chained = [](int groups) {
    std::string text;
    for (int g = 0; g < groups; ++g) {
      text += fmt::format("[[group]]\nname = 'g{}'\n", g);
      if (g + 1 < groups) text += fmt::format("[[instance]]\nname = 'x'\nof = 'g{}'\ngroup = 'g{}'\n", g + 1, g);
    }
    return text + fmt::format("[[object]]\nmesh = 'a.obj'\ngroup = 'g{}'\n", groups - 1);
  };
  EXPECT_THAT(names_of(chained(256)), SizeIs(256));
  EXPECT_THAT(error_of(chained(257)), HasSubstr("'x' is inside more than 255 groups and instances of groups: use fewer"));
}

// The text between ```toml and ``` after a heading of docs/scene-files.md.
std::string documented_example(const std::string& heading) {
  std::ifstream in(HAPTON_SOURCE_DIR "/docs/scene-files.md");
  const std::string page((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::size_t section = page.find("\n## " + heading + "\n");
  const std::size_t begin = page.find("```toml\n", section) + 8;
  return section == std::string::npos ? "" : page.substr(begin, page.find("```\n", begin) - begin);
}

TEST_F(GroupedScene, TheDocumentedExamplesWork) {
  folder_.write("wheel.stl", sample::binary_stl(sample::tetrahedron()));
  const std::string groups = documented_example("Groups and instances");
  EXPECT_THAT(names_of(groups), ElementsAre("rear axle/left", "rear axle/right", "axle/left", "axle/right"));
  const auto scene = load(groups + documented_example("Camera and lights") + documented_example("The workspace"));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_TRUE(scene->view.camera);
  EXPECT_THAT(scene->view.lights, SizeIs(1));
  EXPECT_DOUBLE_EQ(scene->fit_scale, 0.1);
  for (const SceneObject& object : scene->objects) EXPECT_EQ(object.material.stiffness_n_per_m, 400.0) << object.name;
}

// A note about the file occurs only once.
TEST_F(GroupedScene, InstancesReadTheirFileOnce) {
  folder_.write("a.obj", sample::obj(sample::tetrahedron()) + "v 9 9 9\n");  // a vertex of no face: a note for each reading
  const auto scene = load("[[object]]\nmesh = 'a.obj'\n[[instance]]\nname = 'b'\nof = 'a'\n[[instance]]\nname = 'c'\nof = 'a'\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_THAT(scene->notes, SizeIs(1));
}

}  // namespace
}  // namespace hapton
