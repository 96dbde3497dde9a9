#include "core/tool/round_progress.h"

namespace hapton {

bool RoundProgress::is_stalled(const Placement& at, double distance) noexcept {
  const bool is_first = rounds_ == 0;
  if (!is_first && at == last_) return false;
  ++rounds_;
  last_ = at;
  is_best_ = is_first || distance < best_distance_;
  if (is_best_) {
    best_ = at;
    best_distance_ = distance;
  }
  const bool is_gain = is_first || best_distance_ < gained_at_ - least_gain_;
  if (is_gain) gained_at_ = best_distance_;
  since_gain_ = is_gain ? 0 : since_gain_ + 1;
  return since_gain_ >= kPatience;
}

}  // namespace hapton
