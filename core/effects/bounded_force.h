#pragma once

#include "core/math/types.h"

namespace hapton {

// The largest force of any single effect, N. The strongest devices of docs/vendor-devices.md give 20 N, and the governor limits every force
// to the device's, so a larger number in a scene file is probably a typing error.
constexpr double kMaxEffectForceN = 100.0;

// The force, scaled to a magnitude of at most most_n; zero if it is not finite. RT: yes.
inline Vec3 bounded_force(const Vec3& force_n, double most_n) noexcept {
  const double largest = force_n.cwiseAbs().maxCoeff();
  if (!(largest > 0.0) || !force_n.allFinite()) return Vec3::Zero();
  if (largest <= 0.5 * most_n) return force_n;  // sqrt(3) / 2 < 1
  // Scaled first: the square of a finite number may overflow.
  const Vec3 scaled = force_n / largest;
  const double length = scaled.norm();
  return largest * length <= most_n ? force_n : Vec3(scaled * (most_n / length));
}

}  // namespace hapton
