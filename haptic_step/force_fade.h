#pragma once

#include "core/math/types.h"

namespace hapton {

// Takes the force from one method to the next without a pop. The difference between what was felt last and what the next method gives at
// its first sample is added to the next method's forces, and fades straight to nothing: its direction stays, its length only sinks. So no
// step changes the force by more than the next method itself does plus the difference's share of that step. Units: N, s. Frame: W. RT: all.
// Threads: one. Source: docs/decisions/0022-method-switch.md.
class ForceFade {
 public:
  static constexpr double kInContactS = 0.1;  // from the whole difference to nothing, as long as the ramp after a letting go
  static constexpr double kInAirS = 0.01;     // while the next method feels nothing: as fast as the safety governor lets go

  // Another method feels from the next step on.
  void begin() noexcept { is_due_ = true; }

  void forget() noexcept { *this = {}; }

  // The force to be felt, when the method in use gives force_n. A difference that is not finite is left out. Pre: dt_s > 0.
  Vec3 step(const Vec3& force_n, bool contact, double dt_s) noexcept;

  // Something of the difference was in the last step's force.
  bool is_felt() const noexcept { return share_ > 0.0 && !difference_n_.isZero(0.0); }

 private:
  Vec3 felt_n_ = Vec3::Zero();  // last
  Vec3 difference_n_ = Vec3::Zero();
  double share_ = 0.0;  // of the difference, still there
  bool is_due_ = false;
};

}  // namespace hapton
