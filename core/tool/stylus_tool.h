#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/tool/tool_step.h"

namespace hapton {

// What the tool does to a part of the scene that moves. Frame W.
struct ToolPush {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();  // about the grip point of the drawn tool (ToolOutput::X_WP)
};

// The values of the scene's materials that a tool uses. friction, damping: of each object, in the order in which the tool was given them.
struct ToolMaterials {
  double stiffness_n_per_m = 0.0;
  std::vector<CoulombFriction> friction = {};
  std::vector<DampingCoefficients> damping = {};
};

// Interface of a rigid tool for the haptic step. It is computed by the proxy (HeldTool), or by voxels for comparison (HeldVoxels). RT: yes.
// Threads: one.
class StylusTool {
 public:
  StylusTool() = default;
  StylusTool(const StylusTool&) = delete;
  StylusTool& operator=(const StylusTool&) = delete;
  virtual ~StylusTool() = default;

  // Force, torque and drawn pose for one sample.
  virtual ToolOutput step(const ToolInput& input, std::int64_t time_ns) noexcept = 0;
  // The next sample does not continue the motion of the last one. The tool stays where it is; its damping begins with the next motion.
  virtual void forget_motion() noexcept = 0;
  // The hand may have moved around an obstacle since the last sample: at the next sample the tool is put where the device is. If it
  // overlaps the scene there, HeldTool gives no force until it is free.
  virtual void begin_anew() noexcept = 0;
  // True if the tool's pose was known before the last step. While it is false, HeldTool gives no force, and draws the tool at the device.
  virtual bool is_known() const noexcept = 0;
  // Sets new materials, from the next step on. The rotational stiffness changes in proportion to the stiffness, and the tool stays
  // where it is. Pre: one entry for each object of the scene that the tool was given.
  virtual void set_materials(const ToolMaterials& materials) noexcept = 0;
  // Force and torque of the last step's contacts on a part that moves. Pre: `part` is its number among the moving parts, from 0.
  virtual const ToolPush& push_on(std::size_t part) const noexcept = 0;
  // A vertex of the tool, metres from the grip point, along the stylus' axes. Pre: the tool was made from a mesh (ToolStep::make).
  virtual Vec3 vertex_m() const noexcept = 0;
};

}  // namespace hapton
