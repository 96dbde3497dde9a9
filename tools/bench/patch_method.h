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

// Method `proxy` on a scene that is felt by patches, as io_node feels one that haptics_node has sent: parted into tiles, stored, made into
// patches. Here all tiles are there from the start, a patch has few triangles, and the next one is there as soon as it is due. For tests of
// the patches themselves. Material damping, probe radius and friction as in tiles. RT: no. Threads: one.
class PatchMethod final : public ForceMethod {
 public:
  static constexpr std::size_t kTriangles = 128;  // of a patch, where the hand does not jump

  PatchMethod(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override;
  std::optional<Vec3> carried_from() const noexcept override { return touch_.carried_from(); }
  // Nothing: in tiles another material is another scene.
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

// The body as haptics_node has it, cracks sealed, on the grid that its tiles have, so that both are the same surface.
StressBody on_patch_grid(StressBody body);

}  // namespace hapton
