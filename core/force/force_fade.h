#pragma once

#include <algorithm>
#include <utility>

#include "core/math/types.h"

namespace hapton {

// Blends from one method to the next without a force discontinuity. The difference between the last force and the next method's first one
// is added to the next method's forces and fades linearly to zero. So no step changes the force by more than the next method does plus that
// step's share of the difference: a hundredth in contact, a tenth without, however long the step. Units: s; N, or N m for a torque. Frame:
// the same for all forces. RT: all. Threads: one. Source: docs/decisions/0022-method-switch.md.
class ForceFade {
 public:
  static constexpr double kInContactS = 0.1;  // from the whole difference to zero, as long as the governor's ramp up
  static constexpr double kInAirS = 0.01;     // without contact: as fast as the governor releases a force
  // The longest time by which one step advances the fade. Samples may be missing for a while (a slow link, or the hub computes the force
  // itself and sends few), and the force must not jump by what would have faded meanwhile. Below 1 kHz the fade takes longer.
  static constexpr double kMaxStepS = 1e-3;

  // Call when the next step is the first one of another method.
  void begin() noexcept { is_due_ = true; }
  // The same where the difference is known. difference_n: the previous method's force less the new one's, both for the sample of that step.
  // The change of force due to the device's motion since the step before is then not part of the difference that fades.
  void begin_from(const Vec3& difference_n) noexcept { given_difference_n_ += difference_n; }

  void forget() noexcept { *this = {}; }

  // The force to send when the method gives force_n. A difference that is not finite is left out. Pre: dt_s > 0.
  Vec3 step(const Vec3& force_n, bool contact, double dt_s) noexcept {
    const Vec3 known_n = std::exchange(given_difference_n_, Vec3::Zero());
    if (std::exchange(is_due_, false)) {
      difference_n_ = last_force_n_ - force_n;
      remaining_share_ = difference_n_.allFinite() ? 1.0 : 0.0;
    } else if (!known_n.isZero(0.0) && known_n.allFinite()) {
      difference_n_ = known_n + (remaining_share_ > 0.0 ? Vec3(remaining_share_ * difference_n_) : Vec3(Vec3::Zero()));
      remaining_share_ = 1.0;
    }
    if (remaining_share_ > 0.0) remaining_share_ -= std::min(dt_s, kMaxStepS) / (contact ? kInContactS : kInAirS);
    // Once the fade is over, the forces of the method are passed on unchanged, to the last bit.
    last_force_n_ = remaining_share_ > 0.0 ? Vec3(force_n + remaining_share_ * difference_n_) : force_n;
    return last_force_n_;
  }

  // The last step's force contained a part of the difference.
  bool is_active() const noexcept { return remaining_share_ > 0.0 && !difference_n_.isZero(0.0); }

 private:
  Vec3 last_force_n_ = Vec3::Zero();  // returned by the last step
  Vec3 difference_n_ = Vec3::Zero();
  Vec3 given_difference_n_ = Vec3::Zero();  // from begin_from(), for the next step
  double remaining_share_ = 0.0;            // part of difference_n_ that has not faded yet, at most 1; 0 or less: the fade is over
  bool is_due_ = false;
};

}  // namespace hapton
