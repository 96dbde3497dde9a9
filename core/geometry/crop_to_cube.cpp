#include "core/geometry/crop_to_cube.h"

#include <vector>

namespace hapton {
namespace {

// The part of a convex polygon where sign * p[axis] <= limit (Sutherland & Hodgman 1974).
std::vector<Vec3> cut(const std::vector<Vec3>& polygon, int axis, double sign, double limit) {
  std::vector<Vec3> part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& p = polygon[i];
    const Vec3& q = polygon[(i + 1) % polygon.size()];
    const double over_p = sign * p[axis] - limit;
    const double over_q = sign * q[axis] - limit;
    if (over_p <= 0.0) part.push_back(p);
    if ((over_p < 0.0 && over_q > 0.0) || (over_p > 0.0 && over_q < 0.0)) part.push_back(p + over_p / (over_p - over_q) * (q - p));
  }
  return part;
}

}  // namespace

TriangleMesh crop_to_cube(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, const Vec3& centre, double half_side) {
  TriangleMesh cropped;
  for (const std::uint32_t i : triangles) {
    const Vec3 a = mesh.corner(i, 0) - centre;
    const Vec3 b = mesh.corner(i, 1) - centre;
    const Vec3 c = mesh.corner(i, 2) - centre;
    if (a.cwiseMin(b).cwiseMin(c).maxCoeff() > half_side || a.cwiseMax(b).cwiseMax(c).minCoeff() < -half_side) continue;
    std::vector<Vec3> polygon = {a, b, c};
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) polygon = cut(polygon, axis, sign, half_side);
    }
    if (polygon.size() < 3) continue;
    const auto first = static_cast<std::uint32_t>(cropped.vertices.size());
    cropped.vertices.insert(cropped.vertices.end(), polygon.begin(), polygon.end());
    for (std::uint32_t k = 2; k < polygon.size(); ++k) cropped.triangles.push_back({first, first + k - 1, first + k});
  }
  return cropped;
}

}  // namespace hapton
