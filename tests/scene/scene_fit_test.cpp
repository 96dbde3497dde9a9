#include "scene/scene_fit.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(SceneFit, FillsTheBoxInOneDirectionAround0) {
  const Eigen::AlignedBox3d box(Vec3(1, 2, 3), Vec3(3, 3, 4));
  const auto fit = find_fit(box, {0.1, 0.1, 0.1});
  ASSERT_TRUE(fit);
  EXPECT_DOUBLE_EQ(fit->scale, 0.05);
  EXPECT_LT((fit->apply(Vec3(3, 3, 4)) - Vec3(0.05, 0.025, 0.025)).norm(), 1e-16);
  TriangleMesh mesh{.vertices = {{1, 2, 3}}, .triangles = {}};
  SealReport sealed;
  sealed.widest_gap = 2.0;
  sealed.widest_unsealed = 4.0;
  sealed.tolerance = 4.0;
  fit->apply(mesh, sealed);
  EXPECT_LT((mesh.vertices[0] + Vec3(0.05, 0.025, 0.025)).norm(), 1e-16);
  EXPECT_DOUBLE_EQ(sealed.widest_gap, 0.1);
  EXPECT_DOUBLE_EQ(sealed.widest_unsealed, 0.2);
  EXPECT_DOUBLE_EQ(sealed.tolerance, 0.2);
}

TEST(SceneFit, APointHasNoFit) { EXPECT_FALSE(find_fit(Eigen::AlignedBox3d(Vec3(1, 1, 1), Vec3(1, 1, 1)), {1, 1, 1})); }

// The scale, or the scaled vertices, would not be finite.
TEST(SceneFit, ASizeWhoseScaleIsNotFiniteHasNoFit) {
  for (const double length : {1e-310, 1e-200, 1e200, 1e308}) {
    EXPECT_FALSE(find_fit(Eigen::AlignedBox3d(Vec3(0, 0, 0), Vec3(length, length, length)), {1, 1, 1})) << length;
  }
  EXPECT_FALSE(find_fit(Eigen::AlignedBox3d(Vec3(1e200, 0, 0), Vec3(1e200, 1, 1)), {1, 1, 1})) << "too far out";
  for (const double length : {1e-50, 1e50}) {
    EXPECT_TRUE(find_fit(Eigen::AlignedBox3d(Vec3(0, 0, 0), Vec3(length, length, length)), {1, 1, 1})) << length;
  }
}

TEST(SceneFit, WithoutOneEverythingStays) { EXPECT_EQ(SceneFit().apply(Vec3(1, 2, 3)), Vec3(1, 2, 3)); }

}  // namespace
}  // namespace hapton
