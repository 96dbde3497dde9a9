#include "io_node/scene_reach.h"

namespace hapton {
namespace {

Vec3 to_vec(const SceneFacts::Point& p) noexcept { return Eigen::Map<const Eigen::Vector3f>(p.data()).cast<double>(); }

}  // namespace

Pose pose_of(const ViewTransform& view) noexcept {
  Pose X_WS;
  X_WS.matrix().topRows<3>() = Eigen::Map<const Eigen::Matrix<float, 3, 4, Eigen::RowMajor>>(view.X_WS.data()).cast<double>();
  return X_WS;
}

Vec3 point_in_world(const SceneFacts& scene, const Pose& X_WS, std::size_t i) noexcept { return X_WS * to_vec(scene.points_m[i]); }

SceneReach find_reach(const SceneFacts& scene, const Pose& X_WS, const DeviceLimits& limits) noexcept {
  const Vec3 half_S = 0.5 * (to_vec(scene.highest_m) - to_vec(scene.lowest_m));
  const Vec3 middle_W = X_WS * (to_vec(scene.lowest_m) + half_S);
  const Vec3 half_W = X_WS.linear().cwiseAbs() * half_S;
  const Vec3& low = limits.workspace_min_m;
  const Vec3& high = limits.workspace_max_m;
  if (!((high - low).minCoeff() > 0.0) || scene.point_count == 0) return SceneReach::unknown;
  if (2.0 * half_S.maxCoeff() < SceneFacts::kSpeckShare * (high - low).maxCoeff()) return SceneReach::too_small;
  const bool is_apart = ((middle_W + half_W) - low).minCoeff() < 0.0 || (high - (middle_W - half_W)).minCoeff() < 0.0;
  if (is_apart) return SceneReach::out_of_reach;
  for (std::size_t i = 0; i < scene.point_count; ++i) {
    const Vec3 p_W = point_in_world(scene, X_WS, i);
    if ((p_W - low).minCoeff() >= 0.0 && (high - p_W).minCoeff() >= 0.0) return SceneReach::in_reach;
  }
  // The haptics node sends only a few points of the scene. If none of them is inside the workspace, others may be.
  return SceneReach::unknown;
}

}  // namespace hapton
