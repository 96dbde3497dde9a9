#include "scene/scene_loading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "scene/scene_file.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

TEST(SceneLoading, EveryCombinationHasACodeOfItsOwnThatIsNotZero) {
  std::vector<std::uint32_t> codes;
  for (const std::optional<Unit> unit :
       {std::optional<Unit>(), std::optional(Unit::m), std::optional(Unit::cm), std::optional(Unit::mm), std::optional(Unit::in)}) {
    for (const CrackSealing sealing : {CrackSealing::on, CrackSealing::off}) {
      for (const MeshFit fit : {MeshFit::off, MeshFit::workspace}) {
        const SceneLoading loading{unit, sealing, fit};
        const std::uint32_t code = to_code(loading);
        EXPECT_NE(code, 0U);
        EXPECT_EQ(std::count(codes.begin(), codes.end(), code), 0);
        codes.push_back(code);
        EXPECT_EQ(from_code(code), loading);
      }
    }
  }
  for (const std::uint32_t invalid_code : {0U, 2U, 6U, 0x31U, 0xFFFFFFFFU}) EXPECT_FALSE(from_code(invalid_code)) << invalid_code;
}

class FittedMesh : public ::testing::Test {
 protected:
  static Eigen::AlignedBox3d box_of(const Scene& scene) {
    Eigen::AlignedBox3d box;
    for (const Vec3& vertex : scene.objects.at(0).mesh->vertices) box.extend(vertex);
    return box;
  }
  ScratchFolder folder_;
};

TEST(SceneLoading, IsDescribedForPeople) {
  EXPECT_EQ(describe_loading(to_code({.unit = Unit::mm, .fit = MeshFit::workspace})),
            "unit mm, cracks sealed, mesh files fitted to the workspace");
  EXPECT_EQ(describe_loading(to_code({.sealing = CrackSealing::off})), "unit of the file, cracks left open");
  EXPECT_EQ(describe_loading(0), "");
}

// The fit does not depend on the unit of the mesh or on its place.
TEST_F(FittedMesh, LiesInTheMiddleOfTheWorkspaceAndJustFitsItsBox) {
  for (const Unit unit : {Unit::m, Unit::mm, Unit::in}) {
    const auto path = folder_.write("a.obj", "v 1000 5 -40\nv 1300 5 -40\nv 1000 45 -40\nv 1000 5 60\nf 1 2 3\nf 1 3 4\n");
    const auto scene = load_scene(path, {.unit = unit, .fit = MeshFit::workspace});
    ASSERT_TRUE(scene) << scene.error().what;
    const Eigen::AlignedBox3d box = box_of(*scene);
    EXPECT_LT(box.center().norm(), 1e-12);
    const Eigen::Array3d shares = box.sizes().array() / fitted_size_m().array();
    EXPECT_NEAR(shares.maxCoeff(), 1.0, 1e-12);
    EXPECT_THAT(scene->notes, Contains(AllOf(HasSubstr("a.obj"), HasSubstr("scaled by"), HasSubstr("--no-fit"))));
  }
}

TEST_F(FittedMesh, InItsSizeHasNoFactor) {
  const double longest_m = fitted_size_m().x();
  const auto path = folder_.write("a.obj", fmt::format("v 0 0 0\nv {:.17g} 0 0\nv 0 0.01 0\nf 1 2 3\n", longest_m));
  const auto scene = load_scene(path, {.fit = MeshFit::workspace});
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_THAT(scene->notes, Contains(AllOf(HasSubstr(" long, centred in the workspace; --no-fit"))));
}

// The mesh is felt with sealed cracks but drawn as the file has it: both must have the same size and place. Two slopes meet at a ridge
// with a crack; sealing lowers the higher side of the ridge, which has fewer triangles.
TEST_F(FittedMesh, IsFittedAlikeHoweverItsCracksAreTreated) {
  const auto path = folder_.write("roof.obj",
                                  "v 0 1 0\nv 1 1 0\nv 0 0 -0.9\nv 0.5 0 -0.9\nv 1 0 -0.9\nf 1 3 4\nf 1 4 2\nf 2 4 5\n"
                                  "v 0 1.00005 0\nv 1 1.00005 0\nv 0 0 0.9\nv 1 0 0.9\nf 6 7 8\nf 7 9 8\n");
  const auto touched_scene = load_scene(path, {.fit = MeshFit::workspace});
  const auto drawn_scene = load_scene(path, {.sealing = CrackSealing::off, .fit = MeshFit::workspace});
  ASSERT_TRUE(touched_scene && drawn_scene);
  EXPECT_TRUE(touched_scene->objects.at(0).sealed.has_sealed());
  EXPECT_LT(box_of(*touched_scene).sizes().y(), box_of(*drawn_scene).sizes().y()) << "the ridge is lower";
  EXPECT_EQ(touched_scene->fit_scale, drawn_scene->fit_scale);
  EXPECT_EQ(box_of(*touched_scene).min(), box_of(*drawn_scene).min());
}

TEST_F(FittedMesh, IsLeftAsItIsWithoutFit) {
  const auto path = folder_.write("a.obj", "v 1 2 3\nv 2 2 3\nv 1 3 3\nf 1 2 3\n");
  const auto scene = load_scene(path);
  ASSERT_TRUE(scene);
  EXPECT_EQ(box_of(*scene).min(), Vec3(1, 2, 3));
}

TEST_F(FittedMesh, DoesNotChangeASceneFile) {
  folder_.write("a.obj", "v 1 2 3\nv 2 2 3\nv 1 3 3\nf 1 2 3\n");
  const auto scene = load_scene(folder_.write("a.toml", "[[object]]\nmesh = 'a.obj'\n"), {.fit = MeshFit::workspace});
  ASSERT_TRUE(scene);
  EXPECT_EQ(box_of(*scene).min(), Vec3(1, 2, 3));
}

}  // namespace
}  // namespace hapton
