#pragma once

#include "core/tool/placement.h"

namespace hapton {

// Tells when the rounds of a step bring the tool no nearer to the device: they may go round placements whose contacts lead from one to the
// next, or along an edge in ever shorter motions. Units: TouchGeometry's local ones. RT: yes.
class RoundProgress {
 public:
  // Rounds without a gain. Cycles of two to five rounds were seen; steps that converge have gone without a gain for four.
  static constexpr int kPatience = 5;

  // least_gain: what counts as one, in kPatience rounds.
  explicit RoundProgress(double least_gain) : least_gain_(least_gain) {}

  // Of a new step.
  void restart() noexcept { rounds_ = 0; }
  // A round begins there, at this distance from the device. True if the last kPatience motions have gained nothing; a round that begins
  // where the one before began made none.
  bool is_stalled(const Placement& at, double distance) noexcept;
  // The nearest placement at which a round began. Pre: one did.
  const Placement& best() const { return best_; }
  // That is where the last round began.
  bool is_best() const { return is_best_; }

 private:
  double least_gain_;
  int rounds_ = 0;
  int since_gain_ = 0;
  double gained_at_ = 0.0;  // the distance that a gain counts from
  bool is_best_ = false;
  double best_distance_ = 0.0;
  Placement best_;
  Placement last_;
};

}  // namespace hapton
