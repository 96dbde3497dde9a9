#include "scene/find_tool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

struct FindTool : ::testing::Test {
  ScratchFolder folder;
  FindTool() { folder.write("a.obj", sample::obj(sample::tetrahedron())); }

  Result<Scene> load(const std::string& text) { return load_scene(folder.write("a.toml", text)); }
  static constexpr const char* kObject = "[[object]]\nmesh = 'a.obj'\n";
};

TEST_F(FindTool, ASceneMayNameOneInItsOwnPose) {
  const auto plain = load(kObject);
  ASSERT_TRUE(plain);
  EXPECT_FALSE(plain->tool);
  const auto scene =
      load(std::string(kObject) + "[tool]\nmesh = 'a.obj'\nname = 'peg'\nscale = 2.0\nrotation_deg = [0, 0, 90]\nposition_m = [1, 2, 3]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_TRUE(scene->tool);
  EXPECT_EQ(scene->tool->name, "peg");
  EXPECT_EQ(scene->objects.size(), 1U) << "it is not an object";
  const Vec3& before = plain->objects[0].mesh->vertices[1];
  EXPECT_LT((scene->tool->mesh->vertices[1] - Vec3(1 - 2 * before.y(), 2 + 2 * before.x(), 3 + 2 * before.z())).norm(), 1e-12);
  EXPECT_NE(scene->given_hash, plain->given_hash);
}

TEST_F(FindTool, IsAsLargeAsTheSceneIsShownAndHeldWhereAskedFor) {
  const auto scene = load("fit_m = [0.1, 0.1, 0.1]\n" + std::string(kObject) + "[tool]\nmesh = 'a.obj'\ngrip = 'centre'\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_NEAR(compute_bounds(*scene->tool->mesh).extent(), 0.1, 1e-12);
  EXPECT_LT(compute_bounds(*scene->tool->mesh).centre().norm(), 1e-12);
  std::vector<std::string> notes;
  const auto chosen = find_tool({.file = folder.path() / "a.obj"}, *scene, {}, notes);
  ASSERT_TRUE(chosen && *chosen);
  EXPECT_NEAR(compute_bounds(*(*chosen)->mesh).extent(), 0.1, 1e-12);
  EXPECT_EQ((*chosen)->name, "a");
  const auto own = find_tool({}, *scene, {}, notes);
  ASSERT_TRUE(own && *own);
  EXPECT_EQ((*own)->mesh, scene->tool->mesh);
}

// Two nodes may name the same tool in different ways.
TEST_F(FindTool, HasAHashOfItsMeshItsPoseAndItsGrip) {
  folder.write("b.obj", sample::obj(sample::tetrahedron()));
  const auto scene = load(std::string(kObject) + "[tool]\nmesh = 'a.obj'\n");
  ASSERT_TRUE(scene) << scene.error().what;
  std::vector<std::string> notes;
  const auto hash_of = [&](const ToolChoice& choice) { return find_tool(choice, *scene, {}, notes).value()->given_hash; };
  const std::uint64_t own_hash = hash_of({});
  EXPECT_EQ(own_hash, hash_of({.file = folder.path() / "a.obj"}));
  EXPECT_EQ(own_hash, hash_of({.file = folder.path() / "b.obj"})) << "the same mesh";
  EXPECT_NE(own_hash, hash_of({.file = folder.path() / "a.obj", .grip = ToolGrip::center}));
  EXPECT_NE(own_hash, hash_of({.file = folder.path() / "a.obj", .unit = Unit::mm}));
  const auto turned = load(std::string(kObject) + "[tool]\nmesh = 'a.obj'\nrotation_deg = [0, 0, 90]\n");
  const auto centred = load(std::string(kObject) + "[tool]\nmesh = 'a.obj'\ngrip = 'centre'\n");
  ASSERT_TRUE(turned && centred);
  EXPECT_NE(own_hash, turned->tool->given_hash);
  EXPECT_EQ(centred->tool->given_hash, hash_of({.file = folder.path() / "a.obj", .grip = ToolGrip::center}));
}

TEST_F(FindTool, HasAFlawIfItIsFarFromTheGripOrOfAnotherSizeThanTheScene) {
  const auto scene = load(kObject);  // its extent is 2.25 m
  ASSERT_TRUE(scene) << scene.error().what;
  const auto fixes_of = [&](double scale, const Vec3& moved_m = Vec3::Zero()) {
    std::string fixes;
    for (const ToolFlaw& flaw : find_tool_flaws(scaled_and_moved(sample::tetrahedron(), scale, moved_m), *scene)) fixes += flaw.fix;
    return fixes;
  };
  for (const double scale : {1.1e-3, 1.0, 9.9}) EXPECT_EQ(fixes_of(scale), "") << scale;
  for (const double scale : {0.9e-3, 10.1}) EXPECT_THAT(fixes_of(scale), HasSubstr("check the units of both")) << scale;
  // At scale 0.1 the tool is 0.225 m long, and the limit is half the scene's extent; at scale 1 it is twice the tool's own 2.25 m.
  EXPECT_EQ(fixes_of(0.1, Vec3(1.1, 0.0, 0.0)), "");
  EXPECT_THAT(fixes_of(0.1, Vec3(1.2, 0.0, 0.0)), HasSubstr("hold it in the middle"));
  EXPECT_THAT(fixes_of(0.1, Vec3(-1.35, 0.0, 0.0)), HasSubstr("hold it in the middle")) << "0.15 m of it are on this side";
  EXPECT_EQ(fixes_of(1.0, Vec3(0.0, 4.4, 0.0)), "");
  EXPECT_THAT(fixes_of(1.0, Vec3(0.0, 4.6, 0.0)), HasSubstr("hold it in the middle"));
}

TEST(ToolGrips, KeepTheSpellingOfEarlierVersions) {
  EXPECT_EQ(parse_tool_grip("origin"), ToolGrip::origin);
  EXPECT_EQ(parse_tool_grip("centre"), ToolGrip::center);
  EXPECT_EQ(parse_tool_grip("center"), ToolGrip::center);
}

TEST_F(FindTool, SaysWhatIsWrongAndWhere) {
  const auto error_of = [&](const std::string& text) {
    const auto scene = load(kObject + text);
    return scene ? std::string("it was read") : scene.error().what;
  };
  EXPECT_THAT(error_of("[tool]\nname = 'x'\n"), HasSubstr("[tool] has no 'mesh'"));
  EXPECT_THAT(error_of("[tool]\nmesh = 'a.obj'\nmaterial = 'steel'\n"), HasSubstr("line 5"));
  EXPECT_THAT(error_of("[tool]\nmesh = 'a.obj'\ngrip = 'handle'\n"), HasSubstr("'handle' is not a grip point"));
  EXPECT_THAT(error_of("[[tool]]\nmesh = 'a.obj'\n"), HasSubstr("one table [tool]"));
  std::vector<std::string> notes;
  const auto scene = load(kObject);
  EXPECT_FALSE(find_tool({.file = "nowhere.stl"}, *scene, {}, notes));
}

}  // namespace
}  // namespace hapton
