#include "core/effects/surface_snap.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(SurfaceSnap, HoldsTheDeviceUntilItIsOutOfRange) {
  const SurfaceSnap glue = {.stiffness_n_per_m = 200, .range_m = 0.003};
  SurfaceSnap::State state;
  EXPECT_EQ(glue.force({.p_SD = {0, 0, 0.001}}, state), Vec3::Zero()) << "never touched";
  SurfaceSnap::touch({0, 0, 0}, Vec3::UnitZ(), state);
  EXPECT_LT((glue.force({.p_SD = {0.002, 0, 0.001}}, state) - Vec3(0, 0, -0.2)).norm(), 1e-12);
  EXPECT_LT((glue.force({.p_SD = {0.002, 0, 0.003}}, state) - Vec3(0, 0, -0.6)).norm(), 1e-12);
  EXPECT_EQ(glue.force({.p_SD = {0.002, 0, -0.001}}, state), Vec3::Zero()) << "it does not push";
  EXPECT_EQ(glue.force({.p_SD = {0.002, 0, 0.0031}}, state), Vec3::Zero()) << "out of range";
  EXPECT_EQ(glue.force({.p_SD = {0.002, 0, 0.001}}, state), Vec3::Zero()) << "released";
  EXPECT_DOUBLE_EQ(glue.bound_n(), 0.6);
}

TEST(SurfaceSnap, ReleasesFarAlongThePlane) {
  const SurfaceSnap glue = {.stiffness_n_per_m = 200, .range_m = 0.003};
  SurfaceSnap::State state;
  SurfaceSnap::touch({0, 0, 0}, Vec3::UnitZ(), state);
  EXPECT_NE(glue.force({.p_SD = {0.0119, 0, 0.001}}, state), Vec3::Zero());
  EXPECT_EQ(glue.force({.p_SD = {0.0121, 0, 0.001}}, state), Vec3::Zero());
  EXPECT_EQ(glue.force({.p_SD = {0, 0, 0.001}}, state), Vec3::Zero());
}

}  // namespace
}  // namespace hapton
