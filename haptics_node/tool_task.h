#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <thread>

#include "core/force/stiffest.h"
#include "core/tool/held_tool.h"
#include "core/tool/stylus_tool.h"
#include "haptics_node/haptics_options.h"
#include "link/messages.h"
#include "runtime/latency_histogram.h"
#include "scene/scene_file.h"

namespace hapton {

// The warning to log if ToolObstacles::leaves_out is true.
inline constexpr std::string_view kToolLeavesOut =
    "two_sided = false, images and effects of surfaces but viscosity_ns_per_m are ignored: a rigid tool supports stiffness, friction, "
    "damping and viscosity";

// A rigid tool that the stylus holds all the time.
struct LiveTool {
  std::unique_ptr<StylusTool> felt = nullptr;  // null: the stylus is a probe
  HeldTool* followed = nullptr;                // `felt`, if it needs a ToolTask; otherwise null
  ToolCoupling coupling = {};
  std::size_t triangles = 0;
  double voxel_m = 0.0;  // 0: no voxels

  explicit operator bool() const noexcept { return felt != nullptr; }
  // The text that the hub gets in place of a method's description: "name=tool ...", with the coupling at this stiffness (the rotational
  // stiffness changes in proportion).
  HapticsSetup::Text describe(double stiffness_n_per_m) const;
  ToolCoupling coupling_at(double stiffness_n_per_m) const noexcept;
};
// The largest gains of a scene with that tool. scene: in series with the virtual coupling. Pre: there is a tool. RT: no.
LargestGains find_gains(const LiveTool& tool, const TouchScene& scene);

// Makes the rigid tool of the scene (find_tool), if there is one. The tool feels friction, damping and viscosity of the materials, with
// --tool-voxels none of these. Its spring is as stiff as the stiffest material, in series with --coupling. Logs what is left out. Error,
// one line: the tool cannot be made, an option cannot be combined with it, or there is no tool and an option needs one. RT: set-up only.
Result<LiveTool> make_live_tool(const HapticsOptions& options, const Scene& scene);

// The text that the hub gets in place of a method's description: "name=tool ...", with the coupling.
HapticsSetup::Text describe_tool(const HeldTool& tool);

// The slow task of a held tool in a thread of its own: moves the tool along with the device, one step of its pose after another. RT: no;
// the force never waits for it.
class ToolTask {
 public:
  // Pre: tool outlives this.
  explicit ToolTask(HeldTool& tool);
  ~ToolTask();
  ToolTask(const ToolTask&) = delete;
  ToolTask& operator=(const ToolTask&) = delete;

  // Ends the thread; after that, pose_times() is complete.
  void stop() noexcept;
  const LatencyHistogram& pose_times() const noexcept { return pose_times_; }

 private:
  void run() noexcept;

  HeldTool& tool_;
  LatencyHistogram pose_times_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace hapton
