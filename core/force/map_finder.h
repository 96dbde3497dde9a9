#pragma once

#include <cstddef>
#include <memory>

#include "core/effects/surface_maps.h"
#include "core/force/mapped_surface.h"

namespace hapton {

// Finds where a point of a surface lies in its images: on the triangle nearest to it, at first on that of the step before. The triangles
// are those of the mesh file, whatever was sealed for touch. Frame: S. RT: find yes, construction set-up only. Threads: one.
class MapFinder {
 public:
  explicit MapFinder(const SurfaceMaps& maps);
  // On a surface that may be shared. Pre: it is of the triangles of these maps.
  MapFinder(const SurfaceMaps& maps, std::shared_ptr<const MappedSurface> surface);

  // What the images say at the point of the surface nearest to p.
  MapSample find(const Vec3& p) noexcept;

 private:
  SurfaceMaps maps_;
  std::shared_ptr<const MappedSurface> surface_;
  std::size_t last_ = 0;
};

}  // namespace hapton
