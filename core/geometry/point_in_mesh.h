#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Whether a point is inside a closed mesh, and its distance from the surface. Inside means that the winding number is not zero, so points
// in inverted and doubled shells count as well. It is computed along three rays from points displaced by a fixed, tiny share of the extent,
// and the majority decides: no two rays can pass exactly through the same edges or vertices. So the result is valid for points farther from
// the surface than that share; for nearer ones it may be either. Time and memory of construction: linear in the triangles. Time of
// is_inside: linear in the triangles before and behind the point, as seen along x; in all if many are long and thin. RT: no bound on time;
// no heap use in the queries. Frame and unit: those of the mesh. Threads: any.
class PointInMesh {
 public:
  // The largest mean number of cells that list a triangle. Where long triangles need more, the cells are larger: otherwise memory would
  // grow with the triangles times the cells. A free choice: meshes of round triangles need 4 or fewer.
  static constexpr std::size_t kMostListings = 16;

  // jitter: how far the rays are displaced, as a share of the longest side.
  explicit PointInMesh(const TriangleMesh& mesh, double jitter = 1e-7, std::size_t most_listings = kMostListings);

  // Whether the point is inside; false if a coordinate is NaN.
  bool is_inside(const Vec3& p) const;

  // The distance to the nearest triangle. It tests every triangle.
  double compute_distance(const Vec3& p) const;

  std::size_t listings() const { return listed_.size(); }

 private:
  // The cells that the box of a triangle covers, both ends included.
  struct Cells {
    std::size_t first_row, last_row, first_column, last_column;
  };

  int winding_along_x(const Vec3& p) const;
  std::size_t cell_of(double y, double z) const;
  Cells cells_of(std::size_t triangle) const;
  std::size_t count_listings() const;

  TriangleMesh mesh_;  // a copy, so that the original need not outlive this
  Vec3 low_, high_;
  double jitter_m_;
  int cells_;
  std::vector<std::uint32_t> first_;  // where the triangles of each cell begin in listed_; cells_ x cells_ cells over y and z, and the end
  std::vector<std::uint32_t> listed_;
};

}  // namespace hapton
