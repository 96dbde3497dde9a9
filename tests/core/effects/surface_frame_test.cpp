#include "core/effects/surface_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace hapton {
namespace {

constexpr double kFrameStepS = 1e-3;

// Moves at 0.2 m/s and turns at 2 rad/s.
Pose moving_pose(double time_s) {
  Pose X_SF = Pose::Identity();
  X_SF.linear() = Eigen::AngleAxisd(2.0 * time_s, Vec3(1, 2, 2) / 3.0).toRotationMatrix();
  X_SF.translation() = Vec3(0.12, -0.16, 0.0) * time_s;
  return X_SF;
}

TEST(SurfaceFrame, AHandThatIsCarriedAlongRests) {
  SurfaceFrame frame;
  const Vec3 p_FD(0.03, -0.02, 0.05);
  for (int i = 0; i < 500; ++i) {
    const Pose X_SF = moving_pose(kFrameStepS * i);
    frame.advance(X_SF, X_SF * p_FD, kFrameStepS);
    ASSERT_LT((frame.p_FD() - p_FD).norm(), 1e-15);
    ASSERT_LT(frame.motion().norm(), 1e-15);
    ASSERT_LT(frame.velocity().mean().norm(), 1e-12);
    ASSERT_FALSE(frame.has_jumped());
  }
}

TEST(SurfaceFrame, AHandAtRestMovesAgainstIt) {
  SurfaceFrame frame;
  Pose X_SF = Pose::Identity();
  for (int i = 0; i < 20; ++i) {
    X_SF.translation() = Vec3(0.2 * kFrameStepS * i, 0, 0);
    frame.advance(X_SF, {0.1, 0.0, 0.0}, kFrameStepS);
  }
  EXPECT_LT((frame.velocity().mean() - Vec3(-0.2, 0, 0)).norm(), 1e-10);
  EXPECT_LT((frame.velocity().newest() - Vec3(-0.2, 0, 0)).norm(), 1e-10);
  EXPECT_LT((frame.motion() - Vec3(-0.2e-3, 0, 0)).norm(), 1e-13);
}

// The hand goes on moving; the jump of the frame is not a velocity of the hand.
TEST(SurfaceFrame, AJumpIsNoMotionOfTheHand) {
  for (const double sign : {1.0, -1.0}) {
    SurfaceFrame frame;
    Pose X_SF = Pose::Identity();
    for (int i = 0; i < 20; ++i) {
      if (i == 14) X_SF.translation() = Vec3(0.004 * sign, 0.0, 0.01);
      frame.advance(X_SF, {0.05 * kFrameStepS * i, 0.0, 0.0}, kFrameStepS);
      EXPECT_EQ(frame.has_jumped(), i == 14) << i;
      if (i > 8) {
        EXPECT_LT((frame.velocity().mean() - Vec3(0.05, 0, 0)).norm(), 1e-10) << i;
      }
    }
  }
}

TEST(SurfaceFrame, ATurnOfTheSceneIsNoMotionOfTheHand) {
  SurfaceFrame frame;
  const Vec3 p_WD(0.02, 0.01, 0.03);
  Pose X_WS = Pose::Identity();
  for (int i = 0; i < 30; ++i) {
    if (i % 10 == 9) {
      X_WS.translation() += Vec3(0.1, 0.0, -0.05);
      frame.move_last(X_WS.inverse(Eigen::Isometry) * p_WD);
    }
    Pose X_SF = Pose::Identity();
    X_SF.translation() = Vec3(0.0, 0.0, 0.1 * kFrameStepS * i);
    frame.advance(X_SF, X_WS.inverse(Eigen::Isometry) * p_WD, kFrameStepS);
    EXPECT_FALSE(frame.has_jumped()) << i;
    if (i > 8) {
      EXPECT_LT((frame.velocity().mean() - Vec3(0, 0, -0.1)).norm(), 1e-9) << i;
    }
  }
}

// The motion of a touched point within the frame is subtracted while it is touched, and from the remembered samples before that.
TEST(SurfaceFrame, RidesOnAPointThatMovesWithinIt) {
  SurfaceFrame frame;
  const Vec3 v_F(0.0, 0.1, 0.0);
  for (int i = 0; i < 30; ++i) {
    frame.advance(Pose::Identity(), kFrameStepS * i * v_F, kFrameStepS);
    if (i < 12) {
      if (i > 8) {
        EXPECT_LT((frame.velocity().mean() - v_F).norm(), 1e-10);
      }
      continue;
    }
    frame.follow_deformation(kFrameStepS * v_F, kFrameStepS);
    EXPECT_LT(frame.velocity().mean().norm(), 1e-12) << i;
    EXPECT_LT(frame.velocity().newest().norm(), 1e-12) << i;
    EXPECT_LT(frame.motion().norm(), 1e-15) << i;
  }
  frame.advance(Pose::Identity(), kFrameStepS * 30 * v_F, kFrameStepS);
  frame.follow_deformation({0.0, 0.02, 0.0}, kFrameStepS);
  EXPECT_LT((frame.motion() - kFrameStepS * v_F).norm(), 1e-15) << "20 m/s: a jump";
}

TEST(SurfaceFrame, StaysFiniteForAnyPose) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  SurfaceFrame frame;
  for (int i = 0; i < 1000; ++i) {
    Pose X_SF = moving_pose(unit(random));
    X_SF.translation() *= std::pow(10.0, 150.0 * unit(random));
    frame.advance(X_SF, {unit(random), unit(random), unit(random)}, i % 7 == 0 ? 0.0 : kFrameStepS);
    frame.follow_deformation(Vec3::Constant(i % 5 == 0 ? std::numeric_limits<double>::quiet_NaN() : 1e-4), i % 3 == 0 ? 0.0 : kFrameStepS);
    ASSERT_TRUE(frame.velocity().mean().allFinite()) << i;
    ASSERT_TRUE(frame.motion().allFinite()) << i;
  }
}

}  // namespace
}  // namespace hapton
