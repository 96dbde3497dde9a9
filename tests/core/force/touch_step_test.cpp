#include "core/force/touch_step.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchStep make_step() { return TouchStep(*make_method({.name = "sweep"}, {.objects = {{made::shared(made::sheet(0.1, 0.0, 4)), {}}}})); }

TEST(TouchStep, ForceAndOffsetComeBackInTheWorldFrame) {
  // The sheet's normal +z turned to +x and moved to x = 0.5.
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()).toRotationMatrix();
  X_WS.translation() = Vec3(0.5, 0.01, -0.02);
  TouchStep touch = make_step();
  touch.reset({.p_WD = {0.51, 0.03, 0.01}, .X_WS = X_WS});
  const TouchOutput felt = touch.step({.p_WD = {0.498, 0.03, 0.01}, .X_WS = X_WS});
  ASSERT_TRUE(felt.contact);
  EXPECT_NEAR((felt.force_n - Vec3(2.0, 0, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((felt.visual_offset_m - Vec3(0.002, 0, 0)).norm(), 0.0, 1e-12);
}

TEST(TouchStep, FreeSpaceHasNoForceAndNoOffset) {
  TouchStep touch = make_step();
  touch.reset({.p_WD = {0, 0, 0.02}});
  const TouchOutput felt = touch.step({.p_WD = {0, 0, 0.01}});
  EXPECT_FALSE(felt.contact);
  EXPECT_EQ(felt.force_n, Vec3::Zero());
  EXPECT_EQ(felt.visual_offset_m, Vec3::Zero());
}

TEST(TouchStep, TurningTheSceneIntoAStationaryProbeExertsAForce) {
  TouchStep touch = make_step();
  const Vec3 p_WD(0.05, 0.001, 0.002);
  touch.reset({.p_WD = p_WD});
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(-0.1, Vec3::UnitY()).toRotationMatrix();  // raises the sheet at +x by 5 mm
  const TouchOutput felt = touch.step({.p_WD = p_WD, .X_WS = X_WS});
  ASSERT_TRUE(felt.contact);
  EXPECT_GT(felt.force_n[2], 2.5);
}

}  // namespace
}  // namespace hapton
