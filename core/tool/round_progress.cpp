#include "core/tool/round_progress.h"

namespace hapton {

bool RoundProgress::begin_round(const Placement& at, double distance) noexcept {
  const bool is_first = rounds_ == 0;
  if (!is_first && at == last_) return false;
  ++rounds_;
  last_ = at;
  is_best_ = is_first || distance < best_distance_;
  if (is_best_) {
    best_ = at;
    best_distance_ = distance;
  }
  const bool is_gain = is_first || best_distance_ < distance_at_gain_ - least_gain_;
  if (is_gain) distance_at_gain_ = best_distance_;
  rounds_since_gain_ = is_gain ? 0 : rounds_since_gain_ + 1;
  return rounds_since_gain_ >= kPatience;
}

}  // namespace hapton
