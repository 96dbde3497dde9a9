#include "vision_node/surface_finder.h"

#include <algorithm>
#include <utility>

#include "core/geometry/closest_point.h"

namespace hapton {
namespace {

Vec3 find_middle(const TriangleMesh& mesh) {
  Box box;
  for (const Vec3& vertex : mesh.vertices) box.grow(vertex);
  return box.is_empty() ? Vec3(Vec3::Zero()) : box.centre();
}

Box box_about(const TriangleMesh& mesh, std::size_t triangle, const Vec3& origin) {
  Box box;
  for (int k = 0; k < 3; ++k) box.grow(mesh.corner(triangle, k) - origin);
  return box;
}

}  // namespace

SurfaceFinder::SurfaceFinder(std::shared_ptr<const TriangleMesh> mesh)
    : mesh_(std::move(mesh)),
      origin_(find_middle(*mesh_)),
      tree_(mesh_->triangles.size(), [this](std::size_t t) { return box_about(*mesh_, t, origin_); }) {}

Vec3 SurfaceFinder::find_closest(const Vec3& p) const {
  // Any point of the surface bounds the search.
  Vec3 closest = mesh_->corner(0, 0);
  double least = (closest - p).squaredNorm();
  tree_.visit_nearest(p - origin_, least, [&](std::uint32_t t, double) {
    const ClosestPoint found = closest_point(mesh_->corner(t, 0), mesh_->corner(t, 1), mesh_->corner(t, 2), p);
    if (found.distance * found.distance < least) {
      least = found.distance * found.distance;
      closest = found.point;
    }
    return least;
  });
  return closest;
}

}  // namespace hapton
