#pragma once

#include <functional>
#include <memory>
#include <string>

#include "bench/measure/sixdof_scenes.h"

namespace hapton {

// A method that follows the device with a rigid tool: ours, or one that is compared with it. Frame S. Threads: one at a time.
class SixdofMethod {
 public:
  virtual ~SixdofMethod() = default;
  // The tool is at X_SD, free of contact.
  virtual void reset(const Pose& X_SD) = 0;
  // Computes one step of 1 ms: force, torque and the tool's pose X_WP.
  virtual ToolOutput step(const Pose& X_SD) = 0;
  // Does what another thread does between two steps; it is not timed.
  virtual void follow() {}
  // The pose at which the method holds the tool, in the local frame and length unit of `exact`.
  virtual Placement placement(const ToolStep& exact) const = 0;
};

// A method, the name and description that reports show, and how to make it.
struct SixdofMethodKind {
  std::string name;
  std::string what;                      // description in one line
  std::size_t most_triangles = 1 << 30;  // largest scene that is measured: with more triangles a step takes seconds
  std::function<Result<std::unique_ptr<SixdofMethod>>(const SixdofScenario&)> make;
};

// ToolStep. Its placements are bit for bit those of its proxy. threads: number of threads that share the search for contacts.
SixdofMethodKind proxy_tool(int threads = 1);
// HeldTool: the force of each sample comes from the contacts that the slow task found last. The slow task follows the device every `every`
// samples. Its placements are those of the slow task.
SixdofMethodKind force_task(int every);
// VoxelTool with voxels of this size.
SixdofMethodKind voxel_tool(double voxel_m);

// Converts a pose in frame S into the local frame and length unit of `exact`.
Placement local_placement(const ToolStep& exact, const Pose& X_SP);

}  // namespace hapton
