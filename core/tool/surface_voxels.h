#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A cell of a cubic grid that is met by a surface.
struct SurfaceVoxel {
  Eigen::Vector3i cell = Eigen::Vector3i::Zero();
  Vec3 normal = Vec3::Zero();  // unit, outward: area-weighted mean over the triangles that meet it; zero where they cancel
};

// A grid of cubes from `origin_m`: cell c spans origin_m + voxel_m * [c, c + 1].
struct VoxelGrid {
  Vec3 origin_m = Vec3::Zero();
  double voxel_m = 1.0;

  Vec3 centre_m(const Eigen::Vector3i& cell) const { return origin_m + voxel_m * (cell.cast<double>().array() + 0.5).matrix(); }
};

// Every voxel that a triangle of the mesh meets, ascending by z, y, x, each once. The test has 13 separating axes (Akenine-Moeller, "Fast
// 3D Triangle-Box Overlap Testing", 2001); mere touch counts. Error: more than `most` voxels, or cells beyond 2^20; the message names a
// voxel size that fits. Units: m. Time: linear in the triangles, and in the voxels that each meets. RT: set-up only.
Result<std::vector<SurfaceVoxel>> find_surface_voxels(const TriangleMesh& mesh, const VoxelGrid& grid, std::size_t most = 50'000'000);

}  // namespace hapton
