#include "tools/check/sculpt_check.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

SceneObject clay_plate(double thickness_m, double voxel_m, double tool_radius_m) {
  SceneObject object;
  object.name = "plate";
  object.mesh = std::make_shared<const TriangleMesh>(make_box(Vec3(0.08, 0.06, thickness_m), 4));
  object.sculpt = SculptSettings{.voxel_m = voxel_m, .tool_radius_m = tool_radius_m};
  return object;
}

TEST(SculptCheck, AWallOfFewVoxelsIsNamedWithVoxelsThatKeepIt) {
  const CheckFindings findings = check_sculpt(clay_plate(0.005, 0.003, 0.02));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::coarse_voxels);
  EXPECT_EQ(findings[0].object, "plate");
  EXPECT_TRUE(findings[0].place_m);
  EXPECT_EQ(findings[0].what, "a wall is 5 mm thick, and voxels of 3 mm may lose it");
  EXPECT_EQ(findings[0].fix, "give voxel_mm = 2.8 or less, or thicken it") << "5 mm / 1.75 is 2.857";
  EXPECT_TRUE(check_sculpt(clay_plate(0.005, 0.0028, 0.02)).empty());
  EXPECT_TRUE(check_sculpt(clay_plate(0.00526, 0.003, 0.02)).empty()) << "1.75 voxels are 5.25 mm";
  EXPECT_EQ(check_sculpt(clay_plate(0.00524, 0.003, 0.02)).size(), 1U);
}

TEST(SculptCheck, ABallOfLessThanThreeVoxelsIsRough) {
  constexpr double kVoxel = 1.0 / 1024.0;
  EXPECT_TRUE(check_sculpt(clay_plate(0.05, kVoxel, 3.0 * kVoxel)).empty());
  const CheckFindings findings = check_sculpt(clay_plate(0.05, 0.001, 0.0025));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].what, "the ball that carves has a radius of 2.5 mm, 2.5 voxels: what it leaves is rough");
  EXPECT_EQ(findings[0].fix, "give voxel_mm = 0.62 or less, or a larger tool_radius_mm");
  EXPECT_FALSE(findings[0].place_m);
}

TEST(SculptCheck, BothAreReportedAndNothingOfAnObjectThatIsNotCarved) {
  SceneObject object = clay_plate(0.002, 0.003, 0.005);
  EXPECT_EQ(check_sculpt(object).size(), 2U);
  object.sculpt.reset();
  EXPECT_TRUE(check_sculpt(object).empty());
}

}  // namespace
}  // namespace hapton
