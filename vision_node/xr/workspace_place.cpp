#include "vision_node/xr/workspace_place.h"

#include <cmath>

namespace hapton {
namespace {

// If the horizontal part of the unit view direction is at least this (up to 60 degrees up or down), that direction gives the heading.
// Otherwise the direction from the left to the right ear does, which is exact if the head has no roll.
constexpr double kMinLevelPart = 0.5;

double find_heading_rad(const Pose& X_LH) {
  const Vec3 ahead = -X_LH.linear().col(2);
  const Vec3 right = X_LH.linear().col(0);
  if (std::hypot(ahead.x(), ahead.z()) >= kMinLevelPart) return std::atan2(-ahead.x(), -ahead.z());
  return std::atan2(-right.z(), right.x());
}

}  // namespace

Pose find_viewer_origin(const Pose& X_LH, RoomSpace space) {
  Vec3 p_LO = X_LH.translation();
  if (space == RoomSpace::stage) p_LO.y() = 0.0;
  return Eigen::Translation3d(p_LO) * Pose(Eigen::AngleAxisd(find_heading_rad(X_LH), Vec3::UnitY()));
}

void WorkspacePlace::recentre(const Pose& X_LH) {
  X_LO_ = find_viewer_origin(X_LH, space_);
  viewer_motion_m_.setZero();
}

}  // namespace hapton
