#include "vision_node/xr/workspace_place.h"

#include <numbers>

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Quat about(double degrees, const Vec3& axis) { return Quat(Eigen::AngleAxisd(degrees * kDegree, axis)); }

// The pose of a head that turns by heading, then pitch, then roll, in degrees.
Pose head_of(const Vec3& p, double heading, double pitch, double roll) {
  return Eigen::Translation3d(p) * Pose(about(heading, Vec3::UnitY()) * about(pitch, Vec3::UnitX()) * about(roll, Vec3::UnitZ()));
}

void expect_pose(const Pose& found, const Pose& expected) { EXPECT_TRUE(found.isApprox(expected, 1e-9)) << found.matrix(); }

Pose origin_of(const Vec3& p, double heading) { return Eigen::Translation3d(p) * Pose(about(heading, Vec3::UnitY())); }

TEST(WorkspacePlace, AViewerOriginHasTheHeadingAlone) {
  const Vec3 p(0.3, 1.6, -0.2);
  for (const double heading : {-170.0, -60.0, 0.0, 45.0, 120.0}) {
    for (const double pitch : {-50.0, 0.0, 35.0}) {
      for (const double roll : {-30.0, 0.0, 80.0}) {
        expect_pose(find_viewer_origin(head_of(p, heading, pitch, roll), RoomSpace::local), origin_of(p, heading));
      }
    }
    for (const double pitch : {-90.0, -80.0, 88.0}) {
      expect_pose(find_viewer_origin(head_of(p, heading, pitch, 0.0), RoomSpace::local), origin_of(p, heading));
    }
  }
}

TEST(WorkspacePlace, OnAStageTheFloorStaysTheFloor) {
  expect_pose(find_viewer_origin(head_of({0.3, 1.6, -0.2}, 30.0, -20.0, 5.0), RoomSpace::stage), origin_of({0.3, 0.0, -0.2}, 30.0));
}

TEST(WorkspacePlace, StandsWhereItWasPutUntilRecentred) {
  const Pose X_OW = Eigen::Translation3d(0.1, -0.25, -0.5) * Pose(about(20.0, Vec3::UnitY()));
  WorkspacePlace place(X_OW, RoomSpace::local);
  expect_pose(place.X_LW(), X_OW);
  const Pose X_LH = head_of({0.4, 0.1, 0.3}, 90.0, -15.0, 3.0);
  place.recentre(X_LH);
  expect_pose(place.X_LW(), origin_of({0.4, 0.1, 0.3}, 90.0) * X_OW);
  // The viewer has turned to the left by 90 degrees: what is in front of the viewer is along -x.
  EXPECT_LT((place.X_LW().translation() - Vec3(0.4 - 0.5, 0.1 - 0.25, 0.3 - 0.1)).norm(), 1e-9);
}

TEST(WorkspacePlace, MovesOfTheViewerMoveItTheOtherWayAndEndWithRecentring) {
  const Pose X_OW(Eigen::Translation3d(0.0, -0.25, -0.5));
  WorkspacePlace place(X_OW, RoomSpace::local);
  place.move_viewer({0.01, 0.0, 0.0});
  place.move_viewer({0.01, 0.02, -0.03});
  EXPECT_LT((place.X_LW().translation() - Vec3(-0.02, -0.27, -0.47)).norm(), 1e-12);
  place.recentre(Pose::Identity());
  expect_pose(place.X_LW(), X_OW);
}

}  // namespace
}  // namespace hapton
