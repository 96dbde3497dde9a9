#pragma once

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
