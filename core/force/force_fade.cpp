#include "core/force/force_fade.h"

#include <algorithm>
#include <utility>

namespace hapton {

Vec3 ForceFade::step(const Vec3& force_n, bool contact, double dt_s) noexcept {
  const Vec3 known_n = std::exchange(given_difference_n_, Vec3::Zero());
  if (std::exchange(is_due_, false)) {
    difference_n_ = last_force_n_ - force_n;
    share_ = difference_n_.allFinite() ? 1.0 : 0.0;
  } else if (!known_n.isZero(0.0) && known_n.allFinite()) {
    difference_n_ = known_n + (share_ > 0.0 ? Vec3(share_ * difference_n_) : Vec3(Vec3::Zero()));
    share_ = 1.0;
  }
  if (share_ > 0.0) share_ -= std::min(dt_s, kMaxStepS) / (contact ? kInContactS : kInAirS);
  // Once it is over the method's forces pass to the last bit.
  last_force_n_ = share_ > 0.0 ? Vec3(force_n + share_ * difference_n_) : force_n;
  return last_force_n_;
}

}  // namespace hapton
