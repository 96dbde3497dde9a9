#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Whether a point is inside a closed mesh, and its distance from the surface. Inside: the winding number is not zero, so inverted and
// doubled shells count as well. It is computed along three rays from points displaced by a seeded, tiny share of the extent, and the
// majority decides: no two rays can pass exactly through the same edges or vertices. So the result is valid for points farther from the
// surface than that share; for nearer ones it may be either. RT: no bound on time; no heap use in the queries. Frame and unit: the mesh's.
class PointInMesh {
 public:
  // jitter: share of the longest side by which the rays are displaced.
  explicit PointInMesh(const TriangleMesh& mesh, double jitter = 1e-7);

  bool is_inside(const Vec3& p) const;

  // Distance to the nearest triangle; tests every triangle.
  double compute_distance(const Vec3& p) const;

 private:
  int winding_along_x(const Vec3& p) const;
  std::size_t cell_of(double y, double z) const;

  TriangleMesh mesh_;  // a copy, so that the original need not outlive this
  Vec3 low_, high_;
  double jitter_m_;
  int cells_;
  std::vector<std::uint32_t> first_;  // of each cell's triangles in listed_, cells_ x cells_ + 1 over y and z
  std::vector<std::uint32_t> listed_;
};

}  // namespace hapton
