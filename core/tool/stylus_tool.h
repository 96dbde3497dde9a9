#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/tool/tool_step.h"

namespace hapton {

// What the tool does to a part of the scene that moves. Frame W.
struct ToolPush {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nm = Vec3::Zero();  // about the grip point of the tool as it is drawn
};

// What a tool takes from the materials of the scene. friction, damping: of each object, in the order in which the tool was made of them.
struct ToolMaterials {
  double stiffness_n_per_m = 0.0;
  std::vector<CoulombFriction> friction = {};
  std::vector<DampingCoefficients> damping = {};
};

// A rigid tool as the haptic step has it, whatever computes it: the proxy (HeldTool), or voxels for comparison (HeldVoxels). RT: yes.
// Threads: one.
class StylusTool {
 public:
  StylusTool() = default;
  StylusTool(const StylusTool&) = delete;
  StylusTool& operator=(const StylusTool&) = delete;
  virtual ~StylusTool() = default;

  // Force, torque and drawn pose for one sample.
  virtual ToolOutput step(const ToolInput& input, std::int64_t time_ns) noexcept = 0;
  // The samples do not go on from the last one. The tool does, and its damping begins with the next motion.
  virtual void forget_motion() noexcept = 0;
  // The hand may have gone around something since the last sample: the tool is put where the device is at the next one. Where it overlaps
  // something there, HeldTool gives no force until it is free.
  virtual void begin_anew() noexcept = 0;
  // The tool's pose was known before the last step. Until then there is no force, and the tool is drawn at the device.
  virtual bool is_known() const noexcept = 0;
  // Materials have changed: they count from the next step on. The rotational stiffness changes in proportion to the stiffness, and the
  // tool stays where it is. Pre: as many objects as the tool was made of.
  virtual void set_materials(const ToolMaterials& materials) noexcept = 0;
  // Of the last step, what the contacts with a part that moves do to it. Pre: of the parts that move, from 0.
  virtual const ToolPush& push_on(std::size_t part) const noexcept = 0;
  // A vertex of the tool, metres from the grip point, along the stylus' axes. Pre: made of a mesh.
  virtual Vec3 vertex_m() const noexcept = 0;
};

}  // namespace hapton
