#include "scene/workspace_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/scene_file.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

class Workspace : public ::testing::Test {
 protected:
  Workspace() { folder_.write("a.obj", sample::obj(sample::tetrahedron())); }

  Result<Scene> load(const std::string& text) { return load_scene(folder_.write("s.toml", text)); }

  std::string error_of(const std::string& text) {
    const auto scene = load("[[object]]\nmesh = 'a.obj'\n" + text);
    return scene ? "it was read" : scene.error().what;
  }

  ScratchFolder folder_;
};

const std::string kPlacedObject = "[[object]]\nmesh = 'a.obj'\nposition_m = [1, 2, 3]\nrotation_deg = [0, 0, 90]\n";

// The centre of the workspace is the origin; in this test its x axis is the scene's y axis, and 1 m at the hand is 10 m in the scene.
TEST_F(Workspace, SaysWhereTheHandIsInTheScene) {
  const auto scene = load(kPlacedObject + "[workspace]\ncenter_m = [1, 2, 2]\nrotation_deg = [0, 0, 90]\nscale = 10\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const TriangleMesh& mesh = *scene->objects[0].mesh;
  EXPECT_LT((mesh.vertices[0] - Vec3(0, 0, 0.1)).norm(), 1e-12);
  EXPECT_LT((mesh.vertices[1] - Vec3(0.15, 0, 0.1)).norm(), 1e-12) << "1.5 m along the scene's y axis";
  EXPECT_LT((mesh.vertices[2] - Vec3(0, 0.225, 0.1)).norm(), 1e-12);
  EXPECT_EQ(scene->fit_scale, 0.1);
  EXPECT_THAT(scene->notes, ::testing::Contains("[workspace]: scene scaled by 0.1"));
}

TEST_F(Workspace, InItsSizeNeedsNoNote) {
  for (const char* workspace : {"[workspace]\ncenter_m = [1, 2, 2]\n", "[workspace]\nscale = 1\n", "[workspace]\nscale = 1.00001\n"}) {
    const auto scene = load(kPlacedObject + workspace);
    ASSERT_TRUE(scene) << scene.error().what;
    EXPECT_THAT(scene->notes, ::testing::IsEmpty()) << workspace;
  }
  const auto fitted = load("fit_m = [1.5, 9, 9]\n[[object]]\nmesh = 'a.obj'\n");
  ASSERT_TRUE(fitted) << fitted.error().what;
  EXPECT_EQ(fitted->fit_scale, 1.0);
  EXPECT_THAT(fitted->notes, ::testing::IsEmpty());
}

// Stiffness is the one felt at the hand: the scale of the scene does not change it.
TEST_F(Workspace, LeavesTheStiffnessAtTheHand) {
  const std::string material = "material = 'm'\n[material.m]\nstiffness_n_per_m = 500\n";
  const auto scene = load("[workspace]\nscale = 100\n[[object]]\nmesh = 'a.obj'\n" + material);
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->objects[0].material.stiffness_n_per_m, 500.0);
}

TEST_F(Workspace, MovesKeyframesAlong) {
  const auto scene = load(
      "[workspace]\ncenter_m = [1, 0, 0]\nrotation_deg = [0, 90, 0]\nscale = 2\n[[object]]\nmesh = 'a.obj'\n[[object.keyframe]]\ntime_s = "
      "0\n"
      "[[object.keyframe]]\ntime_s = 100\nposition_m = [0, 1, 3]\nrotation_deg = [0, 80, 0]\n");
  ASSERT_TRUE(scene) << scene.error().what;
  const SceneObject& object = scene->objects[0];
  const Quat back(Eigen::AngleAxisd(-M_PI / 2, Vec3::UnitY()));
  const Vec3 in_scene = Vec3(0, 1, 3) + Eigen::AngleAxisd(80.0 * M_PI / 180.0, Vec3::UnitY()) * Vec3(1.5, 0, 0);
  EXPECT_LT((object.motion->pose_at(100.0) * object.mesh->vertices[1] - 0.5 * (back * (in_scene - Vec3(1, 0, 0)))).norm(), 1e-9);
}

TEST_F(Workspace, IsPartOfTheHash) {
  const auto hash_of = [&](const std::string& text) {
    const auto scene = load(kPlacedObject + text);
    return scene ? scene->given_hash : 0;
  };
  const std::uint64_t plain = hash_of("");
  EXPECT_NE(plain, 0U);
  EXPECT_NE(plain, hash_of("[workspace]\nscale = 2\n"));
  EXPECT_NE(plain, hash_of("[workspace]\ncenter_m = [0, 0, 1]\n"));
  EXPECT_NE(plain, hash_of("[workspace]\nrotation_deg = [0, 0, 1]\n"));
}

TEST_F(Workspace, NamesLineKeyAndWhatIsAllowed) {
  EXPECT_THAT(error_of("[[workspace]]\nscale = 1\n"), HasSubstr("'workspace' must be one table [workspace]"));
  EXPECT_THAT(error_of("[workspace]\nscale = 0\n"), HasSubstr("s.toml: line 4: 'scale' in [workspace] is 0: it must be at least 1e-09"));
  EXPECT_THAT(error_of("[workspace]\ncentre_m = [0, 0, 0]\n"),
              HasSubstr("line 4: unknown key 'centre_m' in [workspace]; did you mean 'center_m'?"));
  EXPECT_THAT(error_of("[workspace]\ncenter_m = 1\n"), HasSubstr("'center_m' in [workspace] must be a list of 3 numbers"));
  EXPECT_THAT(error_of("[workspace]\nrotation = [1, 1, 0, 0]\n"), HasSubstr("'rotation' has length"));
  const auto both = load("fit_m = [1, 1, 1]\n[[object]]\nmesh = 'a.obj'\n[workspace]\nscale = 2\n");
  ASSERT_FALSE(both);
  EXPECT_THAT(both.error().what, HasSubstr("line 4: there are 'fit_m' and [workspace]"));
}

}  // namespace
}  // namespace hapton
