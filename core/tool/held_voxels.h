#pragma once

#include <memory>

#include "core/tool/stylus_tool.h"
#include "core/tool/voxel_tool.h"

namespace hapton {

// VoxelTool in the haptic step, in one task: each sample computes the whole tool, however many points it has. It begins where the device is
// at the first sample. A hand that is faster than half a voxel a sample leaves it behind. Where nothing is in contact and the tool is
// farther than kResumeReachM behind, it is put where the device is: the hand may have gone around what the tool would meet on its way.
// Voxels do not know that a tool overlaps them where it is put: they push it at once. Nothing of the scene moves. RT: yes. Threads: one.
class HeldVoxels final : public StylusTool {
 public:
  // vertex_m: as StylusTool has it.
  HeldVoxels(std::unique_ptr<VoxelTool> tool, const Vec3& vertex_m) : tool_(std::move(tool)), vertex_m_(vertex_m) {}

  ToolOutput step(const ToolInput& input, std::int64_t time_ns) noexcept override;
  void forget_motion() noexcept override {}
  void begin_anew() noexcept override { has_begun_ = false; }
  bool is_known() const noexcept override { return is_known_; }
  // Of them voxels have the stiffness.
  void set_materials(const ToolMaterials& materials) noexcept override { tool_->set_stiffness(materials.stiffness_n_per_m); }
  const ToolPush& push_on(std::size_t) const noexcept override { return no_push_; }
  Vec3 vertex_m() const noexcept override { return vertex_m_; }

  const VoxelTool& tool() const { return *tool_; }

 private:
  std::unique_ptr<VoxelTool> tool_;
  Vec3 vertex_m_;
  ToolPush no_push_;
  bool has_begun_ = false;
  bool is_known_ = false;
};

}  // namespace hapton
