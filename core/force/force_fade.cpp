#include "core/force/force_fade.h"

#include <utility>

namespace hapton {

Vec3 ForceFade::step(const Vec3& force_n, bool contact, double dt_s) noexcept {
  if (std::exchange(is_due_, false)) {
    difference_n_ = felt_n_ - force_n;
    share_ = difference_n_.allFinite() ? 1.0 : 0.0;
  }
  if (share_ > 0.0) share_ -= dt_s / (contact ? kInContactS : kInAirS);
  // Once it is over the method's forces pass to the last bit.
  felt_n_ = share_ > 0.0 ? Vec3(force_n + share_ * difference_n_) : force_n;
  return felt_n_;
}

}  // namespace hapton
