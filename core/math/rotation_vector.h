#pragma once

#include <algorithm>
#include <cmath>

#include "core/math/types.h"

namespace hapton {

// The rotation vector (axis times angle, rad, length at most pi) of the rotation that takes `from` to `to`, in the frame in which both are
// given. Pre: unit quaternions. RT: yes.
inline Vec3 turn_between(const Quat& from, const Quat& to) noexcept {
  Quat turn = to * from.conjugate();
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  if (!(sine > 0.0)) return Vec3::Zero();
  return (2.0 * std::atan2(sine, turn.w()) / sine) * turn.vec();
}

// The share of the torque of a rotational spring that is felt where it is twisted by this rotation vector (rad): 1 up to 150 degrees, and
// from there falling linearly to zero at 180 degrees, where the shortest way back reverses. So the torque reverses without a discontinuity,
// and still has a potential. RT: yes.
inline double torque_share(const Vec3& turn) noexcept {
  constexpr double kPi = 3.14159265358979323846;
  constexpr double kFadeFromRad = kPi * 5.0 / 6.0;
  return std::clamp((kPi - turn.norm()) / (kPi - kFadeFromRad), 0.0, 1.0);
}

// The unit quaternion of a rotation vector (rad). RT: yes.
inline Quat turn_by(const Vec3& turn) noexcept {
  const double angle = turn.norm();
  if (!(angle > 0.0)) return Quat::Identity();
  Quat q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = (std::sin(0.5 * angle) / angle) * turn;
  return q;
}

}  // namespace hapton
