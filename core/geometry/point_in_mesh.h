#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Whether a point lies inside a closed mesh, and how far it is from its surface.
// Inside: the winding number is not zero, so inverted and doubled shells count as well. It is taken along three rays from points moved
// aside by a seeded, tiny share of the extent, and the majority decides: no ray can pass exactly through the same edges or vertices as
// another. So the answer holds for points farther from the surface than that share; nearer ones may be called either.
// RT: no bound on time; no heap use in the queries. Frame and unit: the mesh's.
class PointInMesh {
 public:
  // jitter: share of the longest side by which the rays are moved aside.
  explicit PointInMesh(const TriangleMesh& mesh, double jitter = 1e-7);

  bool is_inside(const Vec3& p) const;

  // Distance to the nearest triangle, every one asked.
  double compute_distance(const Vec3& p) const;

 private:
  int winding_along_x(const Vec3& p) const;
  std::size_t cell_of(double y, double z) const;

  TriangleMesh mesh_;  // a copy: what is judged may go away
  Vec3 low_, high_;
  double jitter_m_;
  int cells_;
  std::vector<std::uint32_t> first_;  // of each cell's triangles in listed_, cells_ x cells_ + 1 over y and z
  std::vector<std::uint32_t> listed_;
};

}  // namespace hapton
