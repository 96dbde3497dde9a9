#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "core/collision/wide_bvh.h"
#include "core/effects/surface_maps.h"
#include "core/geometry/closest_point.h"

namespace hapton {

// The triangles of a surface with images, prepared for searches for the one nearest to a point. Frame: S. RT: find yes, construction set-up
// only. Threads: immutable; any number may share it.
class MappedSurface {
 public:
  // Pre: not null.
  explicit MappedSurface(std::shared_ptr<const std::vector<MappedTriangle>> triangles);

  const std::shared_ptr<const std::vector<MappedTriangle>>& triangles() const { return triangles_; }
  bool is_empty() const { return faces_.empty(); }
  // Where the point of the surface nearest to p lies in the images. last: index of the triangle that the last call found (0 at first), with
  // which the search begins; set to the one found now, and kept while p is on that triangle. Pre: p is finite, the surface not empty.
  MapPlace find(const Vec3& p, std::size_t& last) const noexcept;

 private:
  struct Face {
    PreparedTriangle shape;  // corners relative to origin_
    MapPlace place;          // of its corner 0, with the gradients
  };

  std::shared_ptr<const std::vector<MappedTriangle>> triangles_;
  Vec3 origin_ = Vec3::Zero();
  double on_surface_tolerance_m_ = 0.0;  // a point that is nearer to the inside of a triangle is on it: far below what can be felt
  std::vector<Face> faces_;
  WideBvh tree_{std::span<const Box>{}};
};

// Finds where a point of a surface lies in its images: on the nearest triangle; the search begins with that of the step before. The
// triangles are those of the mesh file, even if touch uses a sealed mesh. Frame: S. RT: find yes, construction set-up only. Threads: one.
class MapFinder {
 public:
  explicit MapFinder(const SurfaceMaps& maps) : MapFinder(maps, std::make_shared<const MappedSurface>(maps.triangles)) {}
  // With a surface that other finders may share. Pre: it was made from the triangles of these maps.
  MapFinder(const SurfaceMaps& maps, std::shared_ptr<const MappedSurface> surface) : maps_(maps), surface_(std::move(surface)) {}

  // What the images say at the point of the surface nearest to p.
  MapSample find(const Vec3& p) noexcept {
    return surface_->is_empty() || !p.allFinite() ? MapSample() : maps_.sample(surface_->find(p, last_triangle_));
  }

 private:
  SurfaceMaps maps_;
  std::shared_ptr<const MappedSurface> surface_;
  std::size_t last_triangle_ = 0;
};

}  // namespace hapton
