#include "vision_node/view_culling.h"

namespace hapton {

// The planes of the frustum are sums and differences of the rows of the matrix (Gribb and Hartmann 2001): -w <= x, y, z <= w.
ViewCulling::ViewCulling(const Mat4& clip, const Vec3& p_UE, bool without_backs)
    : p_UE_(p_UE.cast<float>()), without_backs_(without_backs) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      Eigen::Vector4d plane = clip.row(3).transpose() + (side == 0 ? 1.0 : -1.0) * clip.row(axis).transpose();
      const double length = plane.head<3>().norm();
      if (length > 0.0) plane /= length;
      planes_[2 * axis + side] = plane.cast<float>();
    }
  }
}

bool ViewCulling::may_see(const DetailCluster& cluster) const {
  for (const Eigen::Vector4f& plane : planes_) {
    if (plane.head<3>().dot(cluster.centre) + plane.w() < -cluster.radius) return false;
  }
  if (!without_backs_ || cluster.cone_cutoff >= 1.0F) return true;
  const Vec3f towards = cluster.cone_apex - p_UE_;
  return towards.dot(cluster.cone_axis) < cluster.cone_cutoff * towards.norm();
}

}  // namespace hapton
