#include "core/collision/uniform_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/collision/triangle_box.h"

namespace hapton {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Result<void> check(std::size_t triangles, const std::array<int, 3>& division) {
  std::size_t cells = 1;
  for (const int along : division) {
    if (along < 1 || along > UniformGrid::kMaxDivision) {
      return fail("grid: a division of {} along an axis is outside 1..{}; choose another grid division", along, UniformGrid::kMaxDivision);
    }
    cells *= static_cast<std::size_t>(along);
  }
  if (cells > UniformGrid::kMaxCells) {
    return fail("grid: {} x {} x {} is more than {} cells; choose a smaller grid division", division[0], division[1], division[2],
                UniformGrid::kMaxCells);
  }
  if (triangles == 0) {
    return fail("grid: there are no triangles to put into cells; give a mesh that has some area");
  }
  if (triangles >= std::numeric_limits<std::uint32_t>::max()) {
    return fail("grid: {} triangles are more than 32 bits can count; give a smaller mesh", triangles);
  }
  return {};
}

}  // namespace

// The result is monotonic in x even with rounding (a difference, a product with a positive number and floor all are), so a point between
// two others never falls outside the range of their cells. With a single cell, the product could be infinity times zero.
int UniformGrid::cell_along(int axis, double x) const noexcept {
  if (division_[axis] == 1) return 0;
  const double cell = std::floor((x - low_[axis]) * cells_per_metre_[axis]);
  return static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(division_[axis] - 1)));
}

CellBox UniformGrid::find_cells(const Vec3& low, const Vec3& high) const noexcept {
  CellBox box;
  if (!((high.array() >= low_.array()).all() && (low.array() <= high_.array()).all())) {  // also if a coordinate is NaN
    return box;
  }
  for (int axis = 0; axis < 3; ++axis) {
    box.begin[axis] = cell_along(axis, low[axis]);
    box.end[axis] = cell_along(axis, high[axis]) + 1;
  }
  return box;
}

// local: the triangle relative to the grid's lowest corner, so that the limits of cells are simple products.
bool UniformGrid::may_touch_cells(const std::array<Vec3, 3>& local, const CellBox& box) noexcept {
  ++work_;
  // How far a point may be outside of its cell's nominal limits because cell_along rounds.
  const Vec3 rounding = 8.0 * kEpsilon * (high_ - low_);
  const Vec3 low = Vec3(box.begin[0], box.begin[1], box.begin[2]).cwiseProduct(cell_size_) - rounding;
  const Vec3 high = Vec3(box.end[0], box.end[1], box.end[2]).cwiseProduct(cell_size_) + rounding;
  return may_touch(local, low, high);
}

template <class Visit>
void UniformGrid::for_each_cell(const std::array<Vec3, 3>& triangle, Visit&& visit) {
  const std::array<Vec3, 3> local = {triangle[0] - low_, triangle[1] - low_, triangle[2] - low_};
  const CellBox box =
      find_cells(triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]), triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]));
  for_each_touched(local, box, visit);
}

// Halves the box along its longest side, and leaves out a half that the triangle does not touch: it touches no cell of that half.
template <class Visit>
void UniformGrid::for_each_touched(const std::array<Vec3, 3>& local, const CellBox& box, Visit& visit) {
  std::size_t axis = 0;
  for (const std::size_t k : {1U, 2U}) {
    if (box.end[k] - box.begin[k] > box.end[axis] - box.begin[axis]) axis = k;
  }
  const int length = box.end[axis] - box.begin[axis];
  if (length < 1 || !may_touch_cells(local, box)) return;
  if (length == 1) {
    visit(index_of(box.begin[0], box.begin[1], box.begin[2]));
    return;
  }
  CellBox lower = box;
  CellBox upper = box;
  lower.end[axis] = upper.begin[axis] = box.begin[axis] + length / 2;
  for_each_touched(local, lower, visit);
  for_each_touched(local, upper, visit);
}

Result<UniformGrid> UniformGrid::make(std::span<const std::array<Vec3, 3>> triangles, const std::array<int, 3>& division) {
  if (auto checked = check(triangles.size(), division); !checked) {
    return tl::unexpected(checked.error());
  }
  UniformGrid grid;
  grid.low_ = triangles[0][0];
  grid.high_ = triangles[0][0];
  for (const auto& triangle : triangles) {
    for (const Vec3& corner : triangle) {
      grid.low_ = grid.low_.cwiseMin(corner);
      grid.high_ = grid.high_.cwiseMax(corner);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = grid.high_[axis] - grid.low_[axis];
    const double per_metre = division[axis] / extent;
    // No extent, or too little to tell cells apart: one cell that contains everything.
    const bool divisible = extent > 0.0 && std::isfinite(extent) && std::isfinite(per_metre);
    grid.division_[axis] = divisible ? division[axis] : 1;
    grid.cells_per_metre_[axis] = divisible ? per_metre : 0.0;
    grid.cell_size_[axis] = std::isfinite(extent) ? extent / grid.division_[axis] : 0.0;
  }

  const std::size_t cells = static_cast<std::size_t>(grid.division_[0]) * grid.division_[1] * grid.division_[2];
  grid.offsets_.assign(cells + 1, 0);
  std::size_t entries = 0;
  for (const auto& triangle : triangles) {
    grid.for_each_cell(triangle, [&](std::size_t cell) {
      ++grid.offsets_[cell + 1];
      ++entries;
    });
    if (entries > kMaxEntries) {
      return fail("grid: {} x {} x {} cells list more than {} triangles in all; choose a smaller grid division", division[0], division[1],
                  division[2], kMaxEntries);
    }
  }
  grid.occupancy_ = {.cells = cells, .occupied_cells = 0, .entries = entries, .max_triangles_a_cell = 0};
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const std::size_t count = grid.offsets_[cell + 1];
    grid.occupancy_.occupied_cells += count > 0 ? 1 : 0;
    grid.occupancy_.max_triangles_a_cell = std::max(grid.occupancy_.max_triangles_a_cell, count);
    grid.offsets_[cell + 1] += grid.offsets_[cell];
  }
  grid.ids_.resize(entries);
  std::vector<std::uint32_t> next(grid.offsets_.begin(), grid.offsets_.end() - 1);
  for (std::uint32_t id = 0; id < triangles.size(); ++id) {
    grid.for_each_cell(triangles[id], [&](std::size_t cell) { grid.ids_[next[cell]++] = id; });
  }
  return grid;
}

}  // namespace hapton
