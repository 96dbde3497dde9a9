#pragma once

#include <memory>

#include "core/tool/stylus_tool.h"
#include "core/tool/voxel_tool.h"

namespace hapton {

// VoxelTool in the haptic step, in one task: each sample computes all points of the tool, however many there are. At the first sample the
// tool is put at the device. It lags behind a hand faster than half a voxel a sample. If it is not in contact and more than kResumeReachM
// behind, it is put at the device: the hand may have gone around something that the tool would meet on its way.
// If the tool overlaps the scene where it is put, the voxels push it at once. The scene has no moving parts. RT: yes. Threads: one.
class HeldVoxels final : public StylusTool {
 public:
  // vertex_m: as StylusTool::vertex_m.
  HeldVoxels(std::unique_ptr<VoxelTool> tool, const Vec3& vertex_m) : tool_(std::move(tool)), vertex_m_(vertex_m) {}

  ToolOutput step(const ToolInput& input, std::int64_t time_ns) noexcept override;
  void forget_motion() noexcept override {}
  void begin_anew() noexcept override { has_begun_ = false; }
  bool is_known() const noexcept override { return is_known_; }
  // Voxels use only the stiffness.
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
