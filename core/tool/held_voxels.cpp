#include "core/tool/held_voxels.h"

#include <utility>

namespace hapton {

ToolOutput HeldVoxels::step(const ToolInput& input, std::int64_t) noexcept {
  if (!input.X_WD.matrix().allFinite() || !input.X_WS.matrix().allFinite()) return tool_->step(input);
  if (!has_begun_) tool_->reset(input);
  is_known_ = std::exchange(has_begun_, true);
  return tool_->step(input);
}

}  // namespace hapton
