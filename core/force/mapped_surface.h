#pragma once

#include <cstddef>
#include <memory>
#include <utility>
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

  std::shared_ptr<const std::vector<MappedTriangle>> triangles_;
  Vec3 origin_ = Vec3::Zero();
  double on_surface_m_ = 0.0;  // nearer than this a point lies on the triangle that it is above: a rounding of the surface's size
  std::vector<Face> faces_;
  WideBvh tree_{std::span<const Box>{}};
};

// Finds where a point of a surface lies in its images: on the triangle nearest to it, at first on that of the step before. The triangles
// are those of the mesh file, whatever was sealed for touch. Frame: S. RT: find yes, construction set-up only. Threads: one.
class MapFinder {
 public:
  explicit MapFinder(const SurfaceMaps& maps) : MapFinder(maps, std::make_shared<const MappedSurface>(maps.triangles)) {}
  // On a surface that may be shared. Pre: it is of the triangles of these maps.
  MapFinder(const SurfaceMaps& maps, std::shared_ptr<const MappedSurface> surface) : maps_(maps), surface_(std::move(surface)) {}

  // What the images say at the point of the surface nearest to p.
  MapSample find(const Vec3& p) noexcept {
    return surface_->is_empty() || !p.allFinite() ? MapSample() : maps_.sample(surface_->find(p, last_));
  }

 private:
  SurfaceMaps maps_;
  std::shared_ptr<const MappedSurface> surface_;
  std::size_t last_ = 0;
};

}  // namespace hapton
