#pragma once

#include <memory>
#include <vector>

#include "core/collision/wide_bvh.h"
#include "core/effects/surface_maps.h"
#include "core/geometry/closest_point.h"

namespace hapton {

// Finds where a point of a surface lies in its images: on the triangle nearest to it, at first on that of the step before. The triangles
// are those of the mesh file, whatever was sealed for touch. Frame: S. RT: find yes, construction set-up only. Threads: one.
class MapFinder {
 public:
  explicit MapFinder(const SurfaceMaps& maps);

  // What the images say at the point of the surface nearest to p.
  MapSample find(const Vec3& p) noexcept;

 private:
  struct Face {
    PreparedTriangle shape;  // from the origin
    MapPlace place;          // of corner 0
  };

  MapPlace place_on(const Face& face, const Vec3& point) const noexcept;

  SurfaceMaps maps_;
  Vec3 origin_ = Vec3::Zero();
  double on_surface_m_ = 0.0;  // nearer than this a point lies on the triangle that it is above: a rounding of the surface's size
  std::vector<Face> faces_;
  std::unique_ptr<WideBvh> tree_;
  std::size_t last_ = 0;
};

}  // namespace hapton
