// Force shading with authored normals.
#include <gtest/gtest.h>

#include <memory>

#include "core/force/force_method.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// The force after pressing from above, or from below where side is -1.
Vec3 pressed_force(double shading, const Eigen::Vector3f& authored, double side = 1.0) {
  TriangleMesh sheet = make_plane_grid(0.1, 4);
  sheet.authored_normals.assign(sheet.triangles.size(), {authored, authored, authored});
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(std::move(sheet)), Material{}});
  MethodSettings settings;
  settings.shading = shading;
  const auto method = std::move(*make_method(settings, scene));
  method->reset({0.007, 0.003, side * 0.001});
  Vec3 force = Vec3::Zero();
  for (int i = 0; i <= 20; ++i) force = method->step({{0.007, 0.003, side * (0.001 - 1e-4 * i)}, 1e-3}).force_n;
  return force;
}

TEST(AuthoredShading, TurnsTheForceTowardsTheAuthoredNormals) {
  const Eigen::Vector3f tilted(0.6F, 0.0F, 0.8F);
  const Vec3 shaded = pressed_force(1.0, tilted);
  EXPECT_NEAR(shaded.norm(), 1.0, 1e-6) << "the magnitude stays";
  EXPECT_LT((shaded.normalized() - tilted.cast<double>()).norm(), 1e-6);
  EXPECT_LT((pressed_force(0.0, tilted) - Vec3(0, 0, 1)).norm(), 1e-6) << "without shading they are not used";
}

TEST(AuthoredShading, FromBehindATwoSidedSheetTheNormalsAreTurnedRound) {
  const Eigen::Vector3f tilted(0.6F, 0.0F, 0.8F);
  EXPECT_LT((pressed_force(1.0, tilted, -1.0).normalized() + tilted.cast<double>()).norm(), 1e-6);
}

TEST(AuthoredShading, LeavesNormalsOfTheInnerSideOut) { EXPECT_LT((pressed_force(1.0, {0.6F, 0.0F, -0.8F}) - Vec3(0, 0, 1)).norm(), 1e-6); }

}  // namespace
}  // namespace hapton
