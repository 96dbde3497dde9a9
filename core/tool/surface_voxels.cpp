#include "core/tool/surface_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hapton {
namespace {

using Cell = Eigen::Vector3i;

constexpr double kLargestCell = 1 << 20;

// Whether a triangle, given from the middle of a cube of half side h, meets it.
bool meets_cube(const std::array<Vec3, 3>& corner, double h) {
  const std::array<Vec3, 3> edge = {corner[1] - corner[0], corner[2] - corner[1], corner[0] - corner[2]};
  const auto is_apart = [&](const Vec3& axis) {
    const double a = axis.dot(corner[0]);
    const double b = axis.dot(corner[1]);
    const double c = axis.dot(corner[2]);
    const double reach = h * axis.lpNorm<1>();
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

std::uint64_t key_of(const Cell& cell) {
  const auto biased = [](int value) { return static_cast<std::uint64_t>(value + (1 << 20)); };
  return biased(cell.z()) << 42 | biased(cell.y()) << 21 | biased(cell.x());
}

struct Crossing {
  Cell cell;
  Vec3 area;  // of the triangle, along its normal
};

// One voxel for the crossings of one cell.
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
    // What only touches a side belongs to the cells on both sides of it.
    const Cell first = (low.array().ceil() - 1.0).matrix().cast<int>();
    const Cell last = high.array().floor().matrix().cast<int>();
    for (int z = first.z(); z <= last.z(); ++z) {
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int x = first.x(); x <= last.x(); ++x) {
          const Vec3 middle = Vec3(x, y, z).array() + 0.5;
          if (!meets_cube({corner[0] - middle, corner[1] - middle, corner[2] - middle}, 0.5)) continue;
          crossings.push_back({{x, y, z}, area});
          if (crossings.size() > most) {
            return fail("a voxel of {:.3g} m makes more than {} voxels of this mesh; give a larger one", grid.voxel_m, most);
          }
        }
      }
    }
  }
  return merged(std::move(crossings));
}

}  // namespace hapton
