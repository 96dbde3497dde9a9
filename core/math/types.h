#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace hapton {

// Frames are named in monogram notation: p_SD is the position of D in frame S, X_WS the pose of S in W,
// so that p_WD = X_WS * p_SD. W world, D device point, S static scene, T tool, P proxy, C camera.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;
using Pose = Eigen::Isometry3d;

}  // namespace hapton
