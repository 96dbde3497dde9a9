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

// For the log where ToolObstacles::leaves_out.
inline constexpr std::string_view kToolLeavesOut =
    "two_sided = false, images and effects of surfaces but viscosity_ns_per_m are ignored: a rigid tool supports stiffness, friction, "
    "damping and viscosity";

// A rigid tool that the stylus holds all the time.
struct LiveTool {
  std::unique_ptr<StylusTool> felt = nullptr;  // null: the stylus is a probe
  HeldTool* followed = nullptr;                // the same, if a slow task follows the device with it
  ToolCoupling coupling = {};
  std::size_t triangles = 0;
  double voxel_m = 0.0;  // 0: no voxels

  explicit operator bool() const noexcept { return felt != nullptr; }
  // What the hub gets in place of a method's description: "name=tool ...", with the coupling at this stiffness (the rotational one changes
  // in proportion).
  HapticsSetup::Text describe(double stiffness_n_per_m) const;
  ToolCoupling coupling_at(double stiffness_n_per_m) const noexcept;
};
// Of a scene as it is felt now, coupled, with that tool. Pre: there is a tool. RT: no.
LargestGains find_gains(const LiveTool& tool, const TouchScene& scene);

// The rigid tool of the scene (find_tool), if there is one. The tool feels friction, damping and viscosity of the materials, with
// --tool-voxels none of them. Its spring is as stiff as the stiffest of them, coupled as --coupling says. Logs what is left out. Error: one
// line.
Result<LiveTool> make_live_tool(const HapticsOptions& options, const Scene& scene);

// What the hub gets in place of a method's description: "name=tool ...", with the coupling.
HapticsSetup::Text describe_tool(const HeldTool& tool);

// The slow task of a held tool in a thread of its own: follows the device, one step of the pose after the other. RT: none of it is on the
// path of the force.
class ToolTask {
 public:
  // Pre: outlives this.
  explicit ToolTask(HeldTool& tool);
  ~ToolTask();
  ToolTask(const ToolTask&) = delete;
  ToolTask& operator=(const ToolTask&) = delete;

  // Ends the thread; the times are complete then.
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
