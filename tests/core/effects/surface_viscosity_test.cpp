#include "core/effects/surface_viscosity.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(SurfaceViscosity, OpposesTheMotionAlongTheSurface) {
  const SurfaceViscosity oil = {.damping_ns_per_m = 3};
  EXPECT_LT((oil.force({0.1, 0.2, -5}, Vec3::UnitZ(), 10) - Vec3(-0.3, -0.6, 0)).norm(), 1e-12);
  EXPECT_LT((oil.force({0.3, 0.4, -5}, Vec3::UnitZ(), 0.5) - Vec3(-0.3, -0.4, 0)).norm(), 1e-12) << "no more than the contact force";
  EXPECT_EQ(oil.force({0.3, 0.4, -5}, Vec3::UnitZ(), 0.0), Vec3::Zero());
  EXPECT_LE(oil.force({1e5, 0, 0}, Vec3::UnitZ(), 1e9).norm(), kMaxEffectForceN * (1 + 1e-12));
}

}  // namespace
}  // namespace hapton
