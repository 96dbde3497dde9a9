#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/force/evaluation/stress_body.h"
#include "core/force/force_method.h"
#include "patch/patch_maker.h"
#include "patch/patch_store.h"
#include "patch/patch_touch.h"

namespace hapton {

// Method `proxy` on patches, as io_node computes forces on a scene that haptics_node has sent in parts (tiles): a patch is the piece of a
// body around the hand, made of stored tiles. Here all tiles are stored from the start, a patch has few triangles, and each patch is ready
// as soon as it is due. For tests of patches. Damping, probe radius and friction are those of the tiles. Frames: S, which equals W; D the
// device point. RT: no. Threads: one.
class PatchMethod final : public ForceMethod {
 public:
  static constexpr std::size_t kTrianglesPerPatch = 128;  // while the hand does not jump; small, so that the hand often changes patches

  PatchMethod(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::optional<Vec3> carried_from() const noexcept override { return touch_.carried_from(); }
  // Does nothing: the materials are those of the tiles.
  void set_materials(std::span<const Material> materials) noexcept override { (void)materials; }
  std::string describe() const override;

  const PatchTouch::Counts& counts() const noexcept { return touch_.counts(); }

 private:
  void make_patch(const Vec3& p_SD);

  PatchStore store_;
  PatchMaker maker_;
  PatchTouch touch_;
  std::int64_t now_ns_ = 0;
};

// The body as haptics_node has it, cracks sealed, with its vertices on the grid of its tiles, so that both are the same surface.
StressBody on_patch_grid(StressBody body);

}  // namespace hapton
