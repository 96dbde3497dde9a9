#pragma once

#include "core/tool/placement.h"

namespace hapton {

// Tells when the rounds of a step no longer bring the tool nearer to the device: they may repeat a cycle of placements, each of whose
// contacts lead to the next one, or follow an edge in ever shorter motions. Units: TouchGeometry's local ones. RT: yes.
class RoundProgress {
 public:
  // Rounds without a gain. Cycles of two to five rounds were seen; steps that converged had up to four rounds in a row without one.
  static constexpr int kPatience = 5;

  // least_gain: a decrease of the distance to the device within kPatience rounds is a gain only if it is larger than this.
  explicit RoundProgress(double least_gain) : least_gain_(least_gain) {}

  // Call at the start of each step.
  void restart() noexcept { rounds_ = 0; }
  // Call when a round begins: at this placement, at this distance from the device. True: it is stalled, as the last kPatience motions have
  // gained nothing. A round that begins where the one before began does not count, as the tool has not moved.
  bool begin_round(const Placement& at, double distance) noexcept;
  // The placement nearest to the device at which a round of this step began. Pre: begin_round was called in this step.
  const Placement& best() const { return best_; }
  // True if best() is the placement at which the last round began.
  bool is_best() const { return is_best_; }

 private:
  double least_gain_;
  int rounds_ = 0;
  int rounds_since_gain_ = 0;
  double distance_at_gain_ = 0.0;  // the distance at the last gain
  bool is_best_ = false;
  double best_distance_ = 0.0;
  Placement best_;
  Placement last_;
};

}  // namespace hapton
