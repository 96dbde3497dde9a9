#pragma once

#include <functional>
#include <memory>
#include <string>

#include "bench/measure/sixdof_scenes.h"

namespace hapton {

// A way to follow the device with a rigid tool: ours, and those that it is compared with. Frame S. Threads: one at a time.
class SixdofMethod {
 public:
  virtual ~SixdofMethod() = default;
  // The tool is at X_SD, free of contact.
  virtual void reset(const Pose& X_SD) = 0;
  // One step of 1 ms: force, torque, X_WP.
  virtual ToolOutput step(const Pose& X_SD) = 0;
  // What another thread does between two steps: not timed.
  virtual void follow() {}
  // Where the tool is held, in the local units of `exact`.
  virtual Placement placement(const ToolStep& exact) const = 0;
};

// A method under the name that reports show.
struct SixdofMethodKind {
  std::string name;
  std::string what;                      // one line
  std::size_t most_triangles = 1 << 30;  // of the scene: with more, a step takes seconds
  std::function<Result<std::unique_ptr<SixdofMethod>>(const SixdofScenario&)> make;
};

// ToolStep. Its placements are those of its proxy, to the bit. threads: that share the search for contacts.
SixdofMethodKind proxy_tool(int threads = 1);
// HeldTool: the force of each sample from the contacts that the slow task found last, which follows every `every` samples. Its placements
// are those of the slow task.
SixdofMethodKind force_task(int every);
// VoxelTool with voxels of that size.
SixdofMethodKind voxel_tool(double voxel_m);

// In the local units of `exact`, of a pose in frame S.
Placement local_placement(const ToolStep& exact, const Pose& X_SP);

}  // namespace hapton
