#include "vision_node/surface_finder.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/geometry/closest_point.h"

namespace hapton {
namespace {

Vec3 find_middle(const TriangleMesh& mesh) {
  const Box box = Box::of(mesh.vertices);
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

SurfaceFinder::SurfacePoint SurfaceFinder::find_closest(const Vec3& p, std::span<const Vec3> vertices, double max_displacement_m) const {
  SurfacePoint found;
  double least = std::numeric_limits<double>::infinity();
  const auto look_at = [&](std::uint32_t t) {
    const auto corner = [&](std::size_t k) -> const Vec3& { return vertices[static_cast<std::size_t>(mesh_->triangles[t][k])]; };
    const ClosestPoint closest = closest_point(corner(0), corner(1), corner(2), p);
    if (closest.distance < least) {
      least = closest.distance;
      found = {closest.point, t, closest.barycentric};
    }
    return (least + max_displacement_m) * (least + max_displacement_m);
  };
  // The distance to any point of the surface, here to triangle 0, bounds the search.
  tree_.visit_nearest(p - origin_, look_at(0), [&](std::uint32_t t, double) { return look_at(t); });
  return found;
}

}  // namespace hapton
