#include "scene/object_deformation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "scene/scene_report.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

// A square of 0.1 m of two triangles, its corner at the origin of the mesh.
struct ObjectDeformation : testing::Test {
  ObjectDeformation() { folder.write("a.obj", "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3\nf 1 3 4\n"); }

  Result<Scene> load(const std::string& object, const std::string& morphs, const std::string& head = "") {
    return load_scene(folder.write("a.toml", head + "[[object]]\nname = 'skin'\nmesh = 'a.obj'\n" + object + "\n" + morphs));
  }
  std::string error_of(const std::string& object, const std::string& morphs, const std::string& head = "") {
    const auto scene = load(object, morphs, head);
    return scene ? "it was read" : scene.error().what;
  }
  static std::string morph(const std::string& text) { return "[[object.morph]]\n" + text + "\n"; }
  static std::vector<Vec3> shape(const SceneObject& object, double time_s) {
    return object.deformation->vertices_at(object.mesh->vertices, object.deformation->weights_at(time_s));
  }

  ScratchFolder folder;
};

// A push is given in the frame of the mesh: the object's scale, pose and fit transform its direction and length.
TEST_F(ObjectDeformation, APushIsInTheFrameOfTheMesh) {
  const auto scene =
      load("position_m = [0, 0, 0.01]\nrotation_deg = [0, 0, 90]\nscale = 2", morph("push_m = [0.01, 0, 0.02]\nkeys = [[0, 0], [1, 1]]"));
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& skin = scene->objects[0];
  ASSERT_TRUE(skin.deformation);
  EXPECT_EQ(shape(skin, 0.0), skin.mesh->vertices) << "as at rest";
  for (std::size_t v = 0; v < 4; ++v) {
    EXPECT_LT((shape(skin, 0.5)[v] - skin.mesh->vertices[v] - Vec3(0, 0.01, 0.02)).norm(), 1e-15) << v;
  }
  EXPECT_EQ(scene->touch_scene().objects[0].deformation, skin.deformation);
  EXPECT_FALSE(skin.deformation->loops());
}

TEST_F(ObjectDeformation, WithARadiusItFallsOff) {
  const auto scene = load("", morph("push_m = [0, 0, 0.01]\ncenter_m = [0.1, 0, 0]\nradius_m = 0.11\nkeys = [[0, 0], [1, 1]]"));
  ASSERT_TRUE(scene) << scene.error().what;
  const auto vertices = shape(scene->objects[0], 1.0);
  EXPECT_DOUBLE_EQ(vertices[1].z(), 0.01);
  const double share = 1.0 - 0.01 / 0.0121;
  EXPECT_NEAR(vertices[0].z(), 0.01 * share * share, 1e-15);
  EXPECT_EQ(vertices[3].z(), 0.0) << "farther than the radius";
  EXPECT_EQ(scene->objects[0].deformation->moved().size(), 3U);
}

TEST_F(ObjectDeformation, StretchesAlongTheMeshsAxes) {
  const auto scene = load("rotation_deg = [0, 0, 90]", morph("stretch = [1.2, 1, 1]\ncenter_m = [0.05, 0, 0]\nkeys = [[0, 0], [1, 1]]"));
  ASSERT_TRUE(scene) << scene.error().what;
  const auto vertices = shape(scene->objects[0], 1.0);
  EXPECT_LT((vertices[0] - Vec3(0, -0.01, 0)).norm(), 1e-15);
  EXPECT_LT((vertices[2] - Vec3(-0.1, 0.11, 0)).norm(), 1e-15);
}

TEST_F(ObjectDeformation, SeveralAddUpWithTheirOwnTimes) {
  const auto scene = load("loop = true", morph("push_m = [0, 0, 0.01]\nkeys = [[0, 0], [1, 1], [2, 0]]") +
                                             morph("push_m = [0.01, 0, 0]\nkeys = [[0.5, 1], [1.5, 0], [3, 1]]"));
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& skin = scene->objects[0];
  EXPECT_LT((shape(skin, 0.75)[0] - Vec3(0.0075, 0, 0.0075)).norm(), 1e-15);
  EXPECT_LT((shape(skin, 2.5)[0] - Vec3(0.01 * 2.0 / 3.0, 0, 0)).norm(), 1e-15);
  EXPECT_LT((shape(skin, 3.75)[0] - shape(skin, 0.75)[0]).norm(), 1e-12);
}

TEST_F(ObjectDeformation, AFitScalesIt) {
  const std::string morphs = morph("push_m = [0, 0, 0.01]\nkeys = [[0, 0], [1, 1]]");
  const auto scene = load("", morphs, "fit_m = [0.2, 0.2, 0.2]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_NEAR((shape(scene->objects[0], 1.0)[0] - scene->objects[0].mesh->vertices[0]).z(), 0.02, 1e-12);
}

TEST_F(ObjectDeformation, AFastOneNamesTheTimeThatWouldDo) {
  const auto fast = [](const char* keys) { return "push_m = [0, 0, 0.1]\nkeys = " + std::string(keys); };
  EXPECT_THAT(error_of("", morph(fast("[[0, 0], [0.2, 1]]"))),
              HasSubstr("line 5: from 0 to 0.2 s 'skin' deforms at up to 0.5 m/s; a surface may move at 0.25 m/s at most: give it 0.400 s "
                        "or more"));
  EXPECT_TRUE(load("", morph(fast("[[0, 0], [0.4, 1]]"))));
  // The speeds of the deformation and of the object's motion are added.
  const std::string moving = "[[object.keyframe]]\ntime_s = 0\n[[object.keyframe]]\ntime_s = 1\nposition_m = [0.2, 0, 0]\n";
  EXPECT_THAT(error_of("", morph(fast("[[0, 0], [1, 1]]")) + moving), HasSubstr("deforms at up to 0.1 m/s and moves at up to 0.2"));
  EXPECT_TRUE(load("", morph(fast("[[0, 0], [2, 1]]")) + moving));
}

// A raised vertex is farther from the pivot than at rest, so a turn of the object moves it faster.
TEST_F(ObjectDeformation, ATurnCountsWithTheShapeThatReachesFarthest) {
  const std::string rising = morph("push_m = [0, 0, 0.1]\nkeys = [[0, 0], [1, 1]]");
  const auto turning = [](int degrees) {
    return "[[object.keyframe]]\ntime_s = 0\n[[object.keyframe]]\ntime_s = 1\nrotation_deg = [0, 0, " + std::to_string(degrees) + "]\n";
  };
  EXPECT_THAT(error_of("", rising + turning(55)), HasSubstr("deforms at up to 0.1 m/s and moves at up to 0.166"));
  EXPECT_TRUE(load("", rising + turning(45)));
}

TEST_F(ObjectDeformation, HasTheEffectsOfItsMaterial) {
  const auto scene = load("material = 'm'", morph("push_m = [0, 0, 0.01]\nkeys = [[0, 0], [1, 1]]") +
                                                "[material.m]\nviscosity_ns_per_m = 1\nbump_height_m = 0.0005\n");
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_TRUE(scene->touch_scene().objects[0].deforms());
  EXPECT_EQ(scene->touch_scene().objects[0].effects.viscosity.damping_ns_per_m, 1.0);
  EXPECT_TRUE(scene->touch_scene().objects[0].effects.bumps.is_on());
}

TEST_F(ObjectDeformation, RejectsWhatCannotBeFelt) {
  const std::string good = morph("push_m = [0, 0, 0.01]\nkeys = [[0, 0], [1, 1]]");
  EXPECT_THAT(error_of("loop = true", good), HasSubstr("line 5: 'skin' does not end with the weights at its beginning"));
  EXPECT_THAT(error_of("", morph("push_m = [0, 0, 0.01]\ncenter_m = [5, 0, 0]\nradius_m = 0.1\nkeys = [[0, 0], [1, 1]]")),
              HasSubstr("moves no vertex of 'skin'"));
  EXPECT_THAT(error_of("movable = true", good), HasSubstr("movable and deforms"));
  EXPECT_THAT(error_of("material = 'm'", good, "[material.m]\nviscosity_ns_per_m = 1\nsnap_range_m = 0.002\n"),
              HasSubstr("line 8: 'skin' deforms: its material may have every effect but snap: leave snap_range_m out"));
  EXPECT_THAT(error_of("loop = true", ""), HasSubstr("'loop' in [[object]] 1 goes with keyframes or morphs"));
  // Stretched by the factor 0, the triangles become a line.
  EXPECT_THAT(error_of("", morph("stretch = [0, 1, 1]\nkeys = [[0, 0], [1, 1]]")),
              HasSubstr("'skin' deforms, and at 1 s 2 of its 2 triangles"));
}

TEST_F(ObjectDeformation, IsPartOfTheHashes) {
  const auto hashes = [&](const char* keys) {
    const auto scene = load("", morph("push_m = [0, 0, 0.01]\nkeys = " + std::string(keys)));
    EXPECT_TRUE(scene);
    return std::pair(scene->given_hash, hash_scene(scene->touch_scene()));
  };
  const auto one = hashes("[[0, 0], [1, 1]]");
  EXPECT_EQ(one, hashes("[[0, 0], [1, 1]]"));
  EXPECT_NE(one.first, hashes("[[0, 0], [1, 0.9]]").first);
  EXPECT_NE(one.second, hashes("[[0, 0], [1, 0.9]]").second);
}

// haptics_node seals cracks, vision_node does not; both must take the scene for the same one.
TEST_F(ObjectDeformation, TheHashOfTheFilesDoesNotDependOnSealedCracks) {
  // Two squares with a crack of 1 micrometre between them.
  folder.write("a.obj",
               "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nv 0.100001 0 0\nv 0.2 0 0\nv 0.2 0.1 0\nv 0.100001 0.1 0\n"
               "f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n");
  for (const char* head : {"", "fit_m = [0.08, 0.08, 0.08]\n"}) {
    const auto sealed = load("position_m = [0, 0, 0.01]\nscale = 2", morph("push_m = [0, 0, 0.01]\nkeys = [[0, 0], [1, 1]]"), head);
    ASSERT_TRUE(sealed) << sealed.error().what;
    EXPECT_TRUE(sealed->objects[0].sealed.has_sealed());
    const auto unsealed = load_scene(folder.path() / "a.toml", {.sealing = CrackSealing::off, .appearance = AppearanceReading::on});
    ASSERT_TRUE(unsealed) << unsealed.error().what;
    EXPECT_FALSE(unsealed->objects[0].sealed.has_sealed());
    EXPECT_EQ(sealed->given_hash, unsealed->given_hash) << head;
  }
}

TEST_F(ObjectDeformation, IsReported) {
  ASSERT_TRUE(load("", morph("push_m = [0, 0, 0.01]\nkeys = [[0, 0], [1, 1]]")));
  const auto report = make_scene_report(folder.path() / "a.toml");
  ASSERT_TRUE(report);
  EXPECT_THAT(to_text(*report), HasSubstr("deforms by 1 morph, 1 s: 4 vertices move"));
  EXPECT_THAT(to_json(*report), HasSubstr("\"morphs\": 1"));
}

}  // namespace
}  // namespace hapton
