#include "vision_node/viewer_head.h"

#include <numbers>

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(ViewerHead, MovesByKeysAndComesBack) {
  ViewerHead head({{0.1, 0.0, 0.6}, Quat::Identity()}, 0.063);
  head.move({0.01, 0.02, -0.03});
  EXPECT_LT((head.head().p_RH - Vec3(0.11, 0.02, 0.57)).norm(), 1e-15);
  head.reset();
  EXPECT_EQ(head.head().p_RH, Vec3(0.1, 0.0, 0.6));
}

TEST(ViewerHead, MovesAreOnTopOfATracker) {
  ViewerHead head({}, 0.063);
  head.move({0.01, 0.0, 0.0});
  const Quat tilted(Eigen::AngleAxisd(0.3, Vec3::UnitZ()));
  head.track({{0.0, 0.05, 0.7}, tilted});
  EXPECT_EQ(head.head().p_RH, Vec3(0.01, 0.05, 0.7));
  EXPECT_EQ(head.head().q_RH.coeffs(), tilted.coeffs());
}

TEST(ViewerHead, NoKeyLeadsThroughTheScreen) {
  ViewerHead head({}, 0.063);
  for (int n = 0; n < 100; ++n) head.move({0.0, 0.0, -0.01});
  EXPECT_NEAR(head.head().p_RH.z(), kNearestEyeM, 0.0101);
  EXPECT_TRUE(is_possible(head.head(), 0.063));
  head.move({0.0, 0.0, 0.01});
  EXPECT_GT(head.head().p_RH.z(), kNearestEyeM + 0.0099) << "the way back is open at once";
  for (int n = 0; n < 100'000; ++n) head.move({1.0, 0.0, 0.0});
  EXPECT_LE(head.head().p_RH.norm(), kFarthestHeadM);
}

TEST(ViewerHead, ATrackedHeadNearTheScreenTakesNoMoveThroughIt) {
  ViewerHead head({}, 0.063);
  for (int n = 0; n < 40; ++n) head.move({0.0, 0.0, -0.01});
  head.track({{0.0, 0.0, 0.3}, Quat::Identity()});
  EXPECT_EQ(head.head().p_RH.z(), 0.3);
  head.track({{0.0, 0.0, 0.8}, Quat::Identity()});
  EXPECT_NEAR(head.head().p_RH.z(), 0.4, 1e-12);
}

TEST(ViewerHead, MotionIsThatOfTheEyeThatMovesFarther) {
  const Head from;
  EXPECT_EQ(compute_eye_motion_m(from, from, 0.063), 0.0);
  EXPECT_NEAR(compute_eye_motion_m(from, {{0.003, 0.004, 0.6}, Quat::Identity()}, 0.063), 0.005, 1e-15);
  const Quat half_turn(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitZ()));
  EXPECT_NEAR(compute_eye_motion_m(from, {{0.0, 0.0, 0.6}, half_turn}, 0.063), 0.063, 1e-12) << "the eyes change places";
  EXPECT_NEAR(compute_eye_motion_m(from, {{0.01, 0.0, 0.6}, half_turn}, 0.063), 0.073, 1e-12);
  EXPECT_EQ(compute_eye_motion_m(from, {{0.0, 0.0, 0.6}, half_turn}, 0.0), 0.0);
}

TEST(ViewerHead, IsDescribedInCentimetresWhereItHasMoved) {
  const Head home;
  EXPECT_EQ(describe_head(home, home), "");
  EXPECT_EQ(describe_head({{0.004, 0.0, 0.6}, Quat::Identity()}, home), "");
  EXPECT_EQ(describe_head({{-0.031, -0.001, 0.648}, Quat::Identity()}, home), "head -3 0 65 cm");
}

}  // namespace
}  // namespace hapton
