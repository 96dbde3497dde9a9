#include "scene/program_shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "scene/scene_file.h"
#include "scene/scene_hash.h"
#include "scene/scene_report.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

constexpr const char* kSailMesh = "v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n";  // mm
constexpr const char* kByProgram = "deformed_by = \"program\"\nreach_m = 0.02\n";

struct ProgramShapeTest : testing::Test {
  ScratchFolder folder;
  ProgramShapeTest() { folder.write("sail.obj", kSailMesh); }

  Result<Scene> load(const std::string& keys, const std::string& before = "", const std::string& after = "") {
    folder.write("scene.toml", before + "[[object]]\nname = \"sail\"\nmesh = \"sail.obj\"\nunit = \"mm\"\n" + keys + after);
    return load_scene(folder.path() / "scene.toml");
  }
  std::string error_of(const std::string& keys, const std::string& after = "") {
    const auto scene = load(keys, "", after);
    return scene ? "none" : scene.error().what;
  }
};

TEST_F(ProgramShapeTest, AnObjectIsDeformedByProgramsWhereTheSceneFileSaysSo) {
  const auto scene = load(kByProgram);
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& sail = scene->objects[0];
  ASSERT_TRUE(sail.program_shape);
  EXPECT_EQ(sail.program_shape->reach_m, 0.02);
  EXPECT_TRUE(sail.moves());
  EXPECT_TRUE(sail.deforms());
  EXPECT_TRUE(scene->touch_scene().has_motion());
  EXPECT_TRUE(scene->touch_scene().has_deformation());
  EXPECT_TRUE(scene->touch_scene().has_streamed());
  EXPECT_EQ(scene->touch_scene().objects[0].stream_reach_m, 0.02);
  EXPECT_THAT(to_text(*make_scene_report(folder.path() / "scene.toml")), HasSubstr("deformed by programs: 3 vertices, reach 0.02 m"));
  EXPECT_FALSE(load("")->touch_scene().has_motion());
}

// Programs give displacements in the frame of the mesh: the object's rotation and scale apply to them, its translation does not.
TEST_F(ProgramShapeTest, AShapeIsOfTheMeshBeforeScaleAndPose) {
  const auto scene = load("scale = 2.0\nposition_m = [0.1, 0.2, 0.3]\nrotation_deg = [0, 0, 90]\n" + std::string(kByProgram),
                          "fit_m = [0.05, 0.05, 0.05]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& sail = scene->objects[0];
  const double scale = 2.0 * scene->fit_scale;
  EXPECT_NEAR(sail.program_shape->reach_m, 0.02 * scale, 1e-15);
  const std::vector<std::array<float, 3>> shape = {{}, {0.01F, 0.0F, 0.0F}, {0.0F, 0.0F, 0.005F}};
  const auto vertices = sail.program_shape->vertices_of(sail.mesh->vertices, shape);
  ASSERT_EQ(vertices.size(), 3U);
  EXPECT_EQ(vertices[0], sail.mesh->vertices[0]) << "to the last bit";
  EXPECT_LT((vertices[1] - sail.mesh->vertices[1] - Vec3(0, scale * 0.01, 0)).norm(), 1e-9);
  EXPECT_LT((vertices[2] - sail.mesh->vertices[2] - Vec3(0, 0, scale * 0.005)).norm(), 1e-9);
}

TEST_F(ProgramShapeTest, ChangesTheHashesOfTheScene) {
  const auto rigid = load("");
  const auto one = load(kByProgram);
  const auto other = load("deformed_by = \"program\"\nreach_m = 0.03\n");
  ASSERT_TRUE(rigid && one && other);
  EXPECT_NE(rigid->given_hash, one->given_hash);
  EXPECT_NE(one->given_hash, other->given_hash);
  EXPECT_NE(hash_scene(rigid->touch_scene()), hash_scene(one->touch_scene()));
  EXPECT_NE(hash_scene(one->touch_scene()), hash_scene(other->touch_scene()));
}

TEST_F(ProgramShapeTest, SaysWhereAndWhatIsWrong) {
  EXPECT_THAT(error_of("deformed_by = \"hand\"\nreach_m = 0.02\n"), HasSubstr("line 5: 'deformed_by' in"));
  EXPECT_THAT(error_of("deformed_by = \"program\"\n"), HasSubstr("line 5:"));
  EXPECT_THAT(error_of("deformed_by = \"program\"\n"), HasSubstr("no 'reach_m'"));
  EXPECT_THAT(error_of("reach_m = 0.02\n"), HasSubstr("line 5: 'reach_m' in"));
  for (const char* reach : {"0", "-0.01", "nan", "inf", "2e6", "'far'"}) {
    EXPECT_THAT(error_of("deformed_by = \"program\"\nreach_m = " + std::string(reach) + "\n"), HasSubstr("line 6:")) << reach;
  }
  const std::string keys = kByProgram;
  EXPECT_THAT(error_of(keys + "moved_by = \"program\"\n"), HasSubstr("'deformed_by' and 'moved_by': keep one"));
  EXPECT_THAT(error_of(keys + "movable = true\n"), HasSubstr("'deformed_by' and 'movable': keep one"));
  EXPECT_THAT(error_of(keys + "sculpt = true\n"), HasSubstr("'deformed_by' and 'sculpt': keep one"));
  EXPECT_THAT(error_of(keys, "[[object.morph]]\npush_m = [0, 0, 1]\nkeys = [[0, 0], [1, 0]]\n"),
              HasSubstr("'deformed_by' and 'morph': keep one"));
  EXPECT_THAT(error_of(keys, "[[object.keyframe]]\ntime_s = 0\n[[object.keyframe]]\ntime_s = 1\n"),
              HasSubstr("'deformed_by' and 'keyframe': keep one"));
  EXPECT_THAT(error_of(keys + "material = \"sticky\"\n", "[material.sticky]\nsnap_range_m = 0.002\nsnap_stiffness_n_per_m = 200\n"),
              HasSubstr("every effect but snap"));
}

// A crack 0.001 mm wide: sealing it would change the vertices.
TEST_F(ProgramShapeTest, SealedCracksAreAnError) {
  folder.write("sail.obj", "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 100 100 0\nv 100 0.001 0\nv 0 100.001 0\nf 1 2 3\nf 5 4 6\n");
  EXPECT_THAT(error_of(kByProgram), HasSubstr("cracks of it were sealed: add seal_cracks = false, or repair it"));
  EXPECT_TRUE(load(kByProgram + std::string("seal_cracks = false\n")));
}

TEST_F(ProgramShapeTest, TooManyVerticesAreAnError) {
  std::string mesh;
  for (int i = 0; i <= 10'000; ++i) mesh += "v " + std::to_string(i) + " 0 0\n";
  mesh += "v 0 100 0\n";
  for (int i = 1; i <= 10'000; ++i) mesh += "f " + std::to_string(i) + " " + std::to_string(i + 1) + " 10002\n";
  folder.write("sail.obj", mesh);
  EXPECT_THAT(error_of(kByProgram), HasSubstr("has 10002 vertices: at most 10000"));
}

}  // namespace
}  // namespace hapton
