#include "core/tool/surface_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hapton {
namespace {

using Cell = Eigen::Vector3i;

constexpr double kLargestCell = 1 << 20;

// Whether a triangle meets a box; its corners are relative to the box's middle. reach_along: how far the box reaches along an axis.
template <class Reach>
bool meets(const std::array<Vec3, 3>& corner, const Reach& reach_along) {
  const std::array<Vec3, 3> edge = {corner[1] - corner[0], corner[2] - corner[1], corner[0] - corner[2]};
  const auto is_apart = [&](const Vec3& axis) {
    const double a = axis.dot(corner[0]);
    const double b = axis.dot(corner[1]);
    const double c = axis.dot(corner[2]);
    const double reach = reach_along(axis);
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  for (int i = 0; i < 3; ++i) {
    const Vec3 axis = Vec3::Unit(i);
    if (is_apart(axis)) return false;
    for (const Vec3& e : edge) {
      if (is_apart(axis.cross(e))) return false;
    }
  }
  return !is_apart(edge[0].cross(edge[1]));
}

// The cells of a box, from `first` to `last`, both included.
struct VoxelRange {
  Cell first;
  Cell last;

  Vec3 size() const { return (last - first).cast<double>().array() + 1.0; }
};

// Whether the triangle meets the cells; also true for some that it misses by less than kMargin.
bool may_meet(const std::array<Vec3, 3>& corner, const VoxelRange& cells) {
  constexpr double kMargin = 0x1p-20;  // in cells: far above the rounding of cell numbers, which are below 2^20
  const Vec3 half = 0.5 * cells.size();
  const Vec3 middle = cells.first.cast<double>() + half;
  const Vec3 wide = half.array() + kMargin;
  return meets({corner[0] - middle, corner[1] - middle, corner[2] - middle}, [&](const Vec3& axis) { return axis.cwiseAbs().dot(wide); });
}

// Calls use(cell) for each cell of the range that the triangle meets, until use returns false. Large ranges are halved, and halves that the
// triangle misses are left out, so that a long triangle takes the time of the cells that it meets, not of all cells of its box.
template <class Use>
bool for_each_crossed(const std::array<Vec3, 3>& corner, const VoxelRange& cells, const Use& use) {
  constexpr double kMaxTestedSingly = 64.0;  // cells: a range of no more is tested cell by cell
  if (cells.size().prod() > kMaxTestedSingly) {
    if (!may_meet(corner, cells)) return true;
    int axis = 0;
    cells.size().maxCoeff(&axis);
    VoxelRange low = cells;
    VoxelRange high = cells;
    low.last[axis] = cells.first[axis] + (cells.last[axis] - cells.first[axis]) / 2;
    high.first[axis] = low.last[axis] + 1;
    return for_each_crossed(corner, low, use) && for_each_crossed(corner, high, use);
  }
  const auto reach_of_cell = [](const Vec3& axis) { return 0.5 * axis.lpNorm<1>(); };
  for (int z = cells.first.z(); z <= cells.last.z(); ++z) {
    for (int y = cells.first.y(); y <= cells.last.y(); ++y) {
      for (int x = cells.first.x(); x <= cells.last.x(); ++x) {
        const Vec3 middle = Vec3(x, y, z).array() + 0.5;
        if (meets({corner[0] - middle, corner[1] - middle, corner[2] - middle}, reach_of_cell) && !use(Cell(x, y, z))) return false;
      }
    }
  }
  return true;
}

std::uint64_t key_of(const Cell& cell) {
  const auto biased = [](int value) { return static_cast<std::uint64_t>(value + (1 << 20)); };
  return biased(cell.z()) << 42 | biased(cell.y()) << 21 | biased(cell.x());
}

struct Crossing {
  Cell cell;
  Vec3 area;  // area of the triangle, as a vector along its normal
};

// Merges all crossings of a cell into one voxel.
std::vector<SurfaceVoxel> merged(std::vector<Crossing> crossings) {
  std::stable_sort(crossings.begin(), crossings.end(),
                   [](const Crossing& a, const Crossing& b) { return key_of(a.cell) < key_of(b.cell); });
  std::vector<SurfaceVoxel> voxels;
  for (const Crossing& crossing : crossings) {
    if (voxels.empty() || voxels.back().cell != crossing.cell) voxels.push_back({crossing.cell, Vec3::Zero()});
    voxels.back().normal += crossing.area;
  }
  for (SurfaceVoxel& voxel : voxels) {
    if (voxel.normal.norm() > 0.0) voxel.normal.normalize();
  }
  return voxels;
}

}  // namespace

Result<std::vector<SurfaceVoxel>> find_surface_voxels(const TriangleMesh& mesh, const VoxelGrid& grid, std::size_t most) {
  std::vector<Crossing> crossings;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Vec3, 3> corner;
    for (int i = 0; i < 3; ++i) corner[static_cast<std::size_t>(i)] = (mesh.corner(t, i) - grid.origin_m) / grid.voxel_m;
    const Vec3 low = corner[0].cwiseMin(corner[1]).cwiseMin(corner[2]);
    const Vec3 high = corner[0].cwiseMax(corner[1]).cwiseMax(corner[2]);
    if (!(low.cwiseAbs().maxCoeff() < kLargestCell) || !(high.cwiseAbs().maxCoeff() < kLargestCell)) {
      return fail("a voxel of {:.3g} m is too small for this mesh; {:.3g} m fits", grid.voxel_m,
                  grid.voxel_m * std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()) / kLargestCell * 1.01);
    }
    const Vec3 area = 0.5 * (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    // A triangle that only touches the side between two cells belongs to both.
    const Cell first = (low.array().ceil() - 1.0).matrix().cast<int>();
    const Cell last = high.array().floor().matrix().cast<int>();
    const bool fits = for_each_crossed(corner, {first, last}, [&](const Cell& cell) {
      crossings.push_back({cell, area});
      return crossings.size() <= most;
    });
    if (!fits) return fail("a voxel of {:.3g} m makes more than {} voxels of this mesh; give a larger one", grid.voxel_m, most);
  }
  return merged(std::move(crossings));
}

}  // namespace hapton
