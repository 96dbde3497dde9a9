#include "vision_node/view_culling.h"

namespace hapton {

// The planes of the frustum are sums and differences of the rows of the matrix (Gribb and Hartmann 2001): -w <= x, y, z <= w.
ViewCulling::ViewCulling(const Mat4& to_clip, const Vec3& p_UE, DrawnSides sides) : p_UE_(p_UE.cast<float>()), sides_(sides) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      Eigen::Vector4d plane = to_clip.row(3).transpose() + (side == 0 ? 1.0 : -1.0) * to_clip.row(axis).transpose();
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
  if (sides_ == DrawnSides::backs && !cluster.shows_backs) return false;
  if (sides_ == DrawnSides::both || cluster.cone_cutoff >= 1.0F) return true;
  if (sides_ == DrawnSides::fronts) {
    const Vec3f towards = cluster.cone_apex - p_UE_;
    return towards.dot(cluster.cone_axis) < cluster.cone_cutoff * towards.norm();
  }
  // Only backs: none is seen if all triangles show their fronts. The same test with reversed normals, but the apex lies behind the planes
  // of the triangles, so the bounding sphere takes its place (meshopt_Bounds).
  const Vec3f away = p_UE_ - cluster.centre;
  return away.dot(cluster.cone_axis) < cluster.cone_cutoff * away.norm() + cluster.radius;
}

}  // namespace hapton
