#include "tools/check/reach_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace hapton {
namespace {

// A scene fitted into the workspace lies on its faces up to rounding.
constexpr double kRounding = 1e-9;  // of the box
// Nobody misses a thousandth of a surface: scenes are often fitted to a rounded size of the workspace.
constexpr double kLeastShare = 1e-3;
// As io_node has it (SceneReach): a smaller scene is too small to find.
constexpr double kSpeck = 0.02;  // of the workspace's longest side

// A convex polygon of a triangle cut by six planes has nine corners at most.
struct Polygon {
  std::array<Vec3, 9> corners;
  std::size_t count = 0;
  void add(const Vec3& p) { corners[count++] = p; }

  double area() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 2; i < count; ++i) sum += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
    return 0.5 * sum.norm();
  }
};

// The part where sign * (p[axis] - limit) <= 0 (Sutherland & Hodgman 1974).
Polygon cut(const Polygon& whole, int axis, double limit, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < whole.count; ++i) {
    const Vec3& a = whole.corners[i];
    const Vec3& b = whole.corners[(i + 1) % whole.count];
    const double over_a = sign * (a[axis] - limit);
    const double over_b = sign * (b[axis] - limit);
    if (over_a <= 0.0) kept.add(a);
    if ((over_a < 0.0 && over_b > 0.0) || (over_a > 0.0 && over_b < 0.0)) kept.add(a + over_a / (over_a - over_b) * (b - a));
  }
  return kept;
}

double area_inside(const TriangleMesh& mesh, std::size_t t, const Vec3& low, const Vec3& high) {
  Polygon polygon;
  for (int k = 0; k < 3; ++k) polygon.add(mesh.corner(t, k));
  for (int axis = 0; axis < 3; ++axis) {
    polygon = cut(polygon, axis, high[axis], 1.0);
    polygon = cut(polygon, axis, low[axis], -1.0);
  }
  return polygon.area();
}

}  // namespace

Unreached find_unreached(const TriangleMesh& mesh, const Vec3& low, const Vec3& high) {
  const Vec3 margin = Vec3::Constant(kRounding * (high - low).maxCoeff());
  Unreached found;
  std::size_t outside = 0;
  for (const Vec3& p : mesh.vertices) {
    const double distance = (low - margin - p).cwiseMax(p - high - margin).cwiseMax(0.0).norm();
    outside += distance > 0.0 ? 1 : 0;
    if (distance <= found.distance_m) continue;
    found.distance_m = distance;
    found.farthest = p;
  }
  if (outside == 0) return found;
  double all = 0.0;
  double inside = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    all += 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
    inside += area_inside(mesh, t, low - margin, high + margin);
  }
  found.share =
      all > 0.0 ? std::clamp(1.0 - inside / all, 0.0, 1.0) : static_cast<double>(outside) / static_cast<double>(mesh.vertices.size());
  return found;
}

CheckFindings check_reach(const SceneObject& object, const DeviceLimits& limits) {
  const Unreached unreached = find_unreached(*object.mesh, limits.workspace_min_m, limits.workspace_max_m);
  if (unreached.share < kLeastShare) return {};
  const std::string how_much =
      unreached.share > 1.0 - kLeastShare ? "all of it lies" : fmt::format("{:.2g} % of its surface lie", 100.0 * unreached.share);
  return {{SceneFault::out_of_reach, object.name, unreached.farthest,
           fmt::format("{} outside the workspace, up to {:.3g} mm", how_much, 1e3 * unreached.distance_m),
           "move or scale it, or let fit_m fit the scene to the workspace"}};
}

CheckFindings check_size(const Scene& scene, const DeviceLimits& limits) {
  Eigen::AlignedBox3d box;
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& p : object.mesh->vertices) box.extend(p);
  }
  const double longest = box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
  const double workspace = (limits.workspace_max_m - limits.workspace_min_m).maxCoeff();
  if (longest >= kSpeck * workspace) return {};
  return {{SceneFault::too_small, "", Vec3(box.isEmpty() ? Vec3(Vec3::Zero()) : Vec3(box.center())),
           fmt::format("the scene is {:.3g} mm long, far too small for a workspace of {:.3g} mm", 1e3 * longest, 1e3 * workspace),
           "check its unit, or let fit_m fit the scene to the workspace"}};
}

}  // namespace hapton
