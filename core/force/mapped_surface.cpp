#include "core/force/mapped_surface.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

// A share of the size of the surface: far above the contact offset of a proxy (2^-30 of the scene), far below what can be felt.
constexpr double kOnSurface = 0x1p-22;

}  // namespace

MappedSurface::MappedSurface(std::shared_ptr<const std::vector<MappedTriangle>> triangles) : triangles_(std::move(triangles)) {
  Eigen::AlignedBox3d box;
  for (const MappedTriangle& triangle : *triangles_) {
    for (const Vec3& corner : triangle.corner) box.extend(corner);
  }
  if (box.isEmpty()) return;
  origin_ = box.center();
  on_surface_tolerance_m_ = kOnSurface * box.sizes().norm();
  for (const MappedTriangle& triangle : *triangles_) {
    Face face;
    face.shape = PreparedTriangle(triangle.corner[0] - origin_, triangle.corner[1] - origin_, triangle.corner[2] - origin_);
    face.place = map_gradients(triangle);
    faces_.push_back(face);
  }
  tree_ = WideBvh(faces_.size(), [&](std::size_t i) {
    Box around;
    for (const Vec3& corner : faces_[i].shape.corner) around.grow(corner);
    return around;
  });
}

MapPlace MappedSurface::find(const Vec3& p, std::size_t& last_triangle) const noexcept {
  const Vec3 local = p - origin_;
  ClosestPoint nearest = closest_point(faces_[last_triangle].shape, local);
  const bool is_still_there = nearest.feature == TriangleFeature::face && nearest.distance <= on_surface_tolerance_m_;
  if (!is_still_there) {
    tree_.visit_nearest(local, nearest.distance * nearest.distance, [&](std::uint32_t item, double bound_squared) {
      const ClosestPoint found = closest_point(faces_[item].shape, local);
      if (found.distance < nearest.distance) {
        nearest = found;
        last_triangle = item;
      }
      return std::min(bound_squared, nearest.distance * nearest.distance);
    });
  }
  MapPlace place = faces_[last_triangle].place;
  const Vec3 off = nearest.point - faces_[last_triangle].shape.corner[0];
  place.texcoord += Eigen::Vector2d(place.du.dot(off), place.dv.dot(off));
  return place;
}

}  // namespace hapton
