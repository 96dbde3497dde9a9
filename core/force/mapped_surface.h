#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/collision/wide_bvh.h"
#include "core/effects/surface_maps.h"
#include "core/geometry/closest_point.h"

namespace hapton {

// The triangles of a surface with images, prepared so that the one nearest to a point is found. Frame: S. RT: find yes, construction set-up
// only. Threads: immutable; any number may share it.
class MappedSurface {
 public:
  // Pre: not null.
  explicit MappedSurface(std::shared_ptr<const std::vector<MappedTriangle>> triangles);

  const std::shared_ptr<const std::vector<MappedTriangle>>& triangles() const { return triangles_; }
  bool is_empty() const { return faces_.empty(); }
  // The place of the point of the surface nearest to p. last: the triangle found before, where the search begins, and that found now; 0 at
  // first. Pre: p is finite, the surface not empty.
  MapPlace find(const Vec3& p, std::size_t& last) const noexcept;

 private:
  struct Face {
    PreparedTriangle shape;  // from the origin
    MapPlace place;          // of corner 0
  };

  static MapPlace place_on(const Face& face, const Vec3& point) noexcept;

  std::shared_ptr<const std::vector<MappedTriangle>> triangles_;
  Vec3 origin_ = Vec3::Zero();
  double on_surface_m_ = 0.0;  // nearer than this a point lies on the triangle that it is above: a rounding of the surface's size
  std::vector<Face> faces_;
  WideBvh tree_{std::span<const Box>{}};
};

}  // namespace hapton
