#include "core/force/evaluation/certain_minimum.h"

#include <algorithm>
#include <vector>

#include "core/force/reference/half_space_projection.h"
#include "core/geometry/closest_point.h"

namespace hapton {
namespace {

struct NearFace {
  const Triangle* corners = nullptr;
  PreparedTriangle shape;
  Vec3 normal = Vec3::Zero();  // unit, towards the proxy
};

std::uint32_t opposite(const Triangle& triangle, std::uint32_t a, std::uint32_t b) {
  return *std::ranges::find_if(triangle, [&](std::uint32_t corner) { return corner != a && corner != b; });
}

bool joins(const Triangle& triangle, std::uint32_t a, std::uint32_t b) {
  return std::ranges::count(triangle, a) > 0 && std::ranges::count(triangle, b) > 0;
}

// Whether exactly one other face shares the edge, and each of the two lies on the side that the other's normal points to.
bool is_concave(const TriangleMesh& mesh, const std::vector<NearFace>& faces, const NearFace& face, int k) {
  const std::uint32_t a = (*face.corners)[k];
  const std::uint32_t b = (*face.corners)[(k + 1) % 3];
  const NearFace* other = nullptr;
  for (const NearFace& candidate : faces) {
    if (candidate.corners == face.corners || !joins(*candidate.corners, a, b)) continue;
    if (other != nullptr) return false;
    other = &candidate;
  }
  if (other == nullptr) return false;
  const Vec3& on_edge = mesh.vertices[a];
  return face.normal.dot(mesh.vertices[opposite(*other->corners, a, b)] - on_edge) >= 0.0 &&
         other->normal.dot(mesh.vertices[opposite(*face.corners, a, b)] - on_edge) >= 0.0;
}

}  // namespace

bool is_certain_minimum(const TriangleMesh& mesh, TriangleBoxes& boxes, const Vec3& proxy, const Vec3& device, double radius) {
  std::vector<NearFace> faces;
  std::vector<HalfSpace> planes;
  for (const std::uint32_t i : boxes.find_near(proxy, radius)) {
    const Triangle& triangle = mesh.triangles[i];
    const Vec3& a = mesh.vertices[triangle[0]];
    const Vec3& b = mesh.vertices[triangle[1]];
    const Vec3& c = mesh.vertices[triangle[2]];
    // Far from the origin, the boxes, in single precision, also let through many triangles that are not near.
    const Vec3 beside = (a.cwiseMin(b).cwiseMin(c) - proxy).cwiseMax(proxy - a.cwiseMax(b).cwiseMax(c));
    if (beside.maxCoeff() > radius) continue;
    const PreparedTriangle shape(a, b, c);
    if (closest_point(shape, proxy).distance > radius) continue;
    const double height = shape.normal.dot(proxy - shape.corner[shape.base]);
    if (!shape.has_face || height == 0.0) return false;
    const Vec3 normal = height > 0.0 ? shape.normal : Vec3(-shape.normal);
    faces.push_back({&triangle, shape, normal});
    planes.push_back({normal, -std::abs(height)});
  }
  if (faces.empty()) return false;
  for (const NearFace& face : faces) {
    for (int k = 0; k < 3; ++k) {
      const Vec3& a = face.shape.corner[k];
      const Vec3& b = face.shape.corner[(k + 1) % 3];
      if (closest_point(a, b, b, proxy).distance <= radius && !is_concave(mesh, faces, face, k)) return false;
    }
  }
  const double rounding = 0x1p-48 * (device - proxy).norm();
  const HalfSpaceProjection nearest = project_onto_half_spaces(device - proxy, planes, rounding);
  return nearest.feasible && nearest.point.norm() <= 0.5 * radius;
}

}  // namespace hapton
