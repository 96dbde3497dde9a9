#include "core/tool/held_voxels.h"

#include <utility>

#include "core/math/contact_resumption.h"

namespace hapton {

ToolOutput HeldVoxels::step(const ToolInput& input, std::int64_t) noexcept {
  if (!input.X_WD.matrix().allFinite() || !input.X_WS.matrix().allFinite()) return tool_->step(input);
  if (!has_begun_) tool_->reset(input);
  is_known_ = std::exchange(has_begun_, true);
  const ToolOutput felt = tool_->step(input);
  const double lag_m = (input.X_WS * tool_->placement().position - input.X_WD.translation()).norm();
  if (!felt.contact && lag_m > kResumeReachM) tool_->reset(input);
  return felt;
}

}  // namespace hapton
