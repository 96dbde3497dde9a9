#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// Half-open ranges of cells along each axis; the box is empty if any range is empty.
struct CellBox {
  std::array<int, 3> begin = {};
  std::array<int, 3> end = {};
};

// How full a grid is. Means and maximum are over occupied cells, as in the memo.
struct GridOccupancy {
  std::size_t cells = 0;
  std::size_t occupied_cells = 0;
  std::size_t entries = 0;  // the lengths of all lists of triangles, summed over the cells
  std::size_t max_triangles_a_cell = 0;

  double occupied_share() const { return cells == 0 ? 0.0 : static_cast<double>(occupied_cells) / static_cast<double>(cells); }
  double mean_triangles_a_cell() const {
    return occupied_cells == 0 ? 0.0 : static_cast<double>(entries) / static_cast<double>(occupied_cells);
  }
};

// The static world divided into equal axis-aligned cells, each with the list of the triangles that touch it, in flat arrays. The grid spans
// the triangles' bounding box; an axis without extent has one cell. Post: a triangle is listed in every cell that contains a point of it,
// and perhaps, by rounding, in a neighbouring cell. Time of make: in proportion to the length of all lists, times a logarithm; not to the
// cells in a triangle's bounding box, of which a long thin triangle touches few. Source: memo 4.2.2, first step of the precalculation. RT:
// find_cells, triangles_in, occupancy yes; make set-up only. Threads: any number of readers.
class UniformGrid {
 public:
  // Most cells along one axis; a free choice, as kMaxCells and kMaxEntries bound the memory.
  static constexpr int kMaxDivision = 1024;
  static constexpr std::size_t kMaxCells = std::size_t{1} << 26;    // 256 MiB of offsets
  static constexpr std::size_t kMaxEntries = std::size_t{1} << 29;  // 2 GiB of list entries

  // Error: a division outside 1..kMaxDivision, more cells or list entries than the limits above, no triangles, too many triangles.
  // Pre: all corners are finite.
  static Result<UniformGrid> make(std::span<const std::array<Vec3, 3>> triangles, const std::array<int, 3>& division);

  // The cells that the axis-aligned box low..high overlaps; none if the box lies outside the grid, or a coordinate is NaN.
  CellBox find_cells(const Vec3& low, const Vec3& high) const noexcept;

  // The numbers of the triangles that touch one cell, in ascending order. Pre: 0 <= x < division()[0], likewise for y and z.
  std::span<const std::uint32_t> triangles_in(int x, int y, int z) const noexcept {
    const std::size_t cell = index_of(x, y, z);
    return {ids_.data() + offsets_[cell], ids_.data() + offsets_[cell + 1]};
  }

  const std::array<int, 3>& division() const { return division_; }
  const Vec3& low() const { return low_; }
  const Vec3& high() const { return high_; }
  const GridOccupancy& occupancy() const { return occupancy_; }
  std::size_t work() const { return work_; }  // number of triangle-box tests in make

 private:
  std::size_t index_of(int x, int y, int z) const noexcept { return (static_cast<std::size_t>(z) * division_[1] + y) * division_[0] + x; }
  int cell_along(int axis, double x) const noexcept;
  bool may_touch_cells(const std::array<Vec3, 3>& local, const CellBox& box) noexcept;
  template <class Visit>
  void for_each_cell(const std::array<Vec3, 3>& triangle, Visit&& visit);
  template <class Visit>
  void for_each_touched(const std::array<Vec3, 3>& local, const CellBox& box, Visit& visit);

  std::array<int, 3> division_ = {1, 1, 1};
  Vec3 low_ = Vec3::Zero();
  Vec3 high_ = Vec3::Zero();
  Vec3 cells_per_metre_ = Vec3::Zero();
  Vec3 cell_size_ = Vec3::Zero();
  std::vector<std::uint32_t> offsets_;
  std::vector<std::uint32_t> ids_;
  GridOccupancy occupancy_;
  std::size_t work_ = 0;
};

}  // namespace hapton
