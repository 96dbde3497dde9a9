#include "tools/check/sculpt_check.h"

#include <fmt/format.h>

#include "core/base/rounded_down.h"
#include "core/collision/wall_thickness.h"

namespace hapton {
namespace {

// A wall that lies between the nodes of the voxel grid, with none inside it, is lost.
constexpr double kMinWallVoxels = 1.75;           // in voxels: just above the diagonal of one
constexpr double kMinRadiusVoxels = 3.0;          // in voxels; a smaller ball leaves a rough surface
constexpr double kRecommendedRadiusVoxels = 4.0;  // in voxels; above the minimum, so that the advice has a margin

}  // namespace

CheckFindings check_sculpt(const SceneObject& object) {
  CheckFindings findings;
  if (!object.sculpt) return findings;
  const double voxel_m = object.sculpt->voxel_m;
  const ThinWalls walls = find_thin_walls(*object.mesh, kMinWallVoxels * voxel_m);
  if (walls.thinnest) {
    findings.push_back(
        {SceneFault::coarse_voxels, object.name, walls.thinnest->point,
         fmt::format("a wall is {:.3g} mm thick, and voxels of {:.3g} mm may lose it", 1e3 * walls.thinnest->thickness, 1e3 * voxel_m),
         fmt::format("give voxel_mm = {:.2g} or less, or thicken it", rounded_down(1e3 * walls.thinnest->thickness / kMinWallVoxels))});
  }
  if (object.sculpt->tool_radius_m < kMinRadiusVoxels * voxel_m) {
    findings.push_back({SceneFault::coarse_voxels, object.name, std::nullopt,
                        fmt::format("the ball that carves has a radius of {:.3g} mm, {:.2g} voxels: what it leaves is rough",
                                    1e3 * object.sculpt->tool_radius_m, object.sculpt->tool_radius_m / voxel_m),
                        fmt::format("give voxel_mm = {:.2g} or less, or a larger tool_radius_mm",
                                    rounded_down(1e3 * object.sculpt->tool_radius_m / kRecommendedRadiusVoxels))});
  }
  return findings;
}

}  // namespace hapton
