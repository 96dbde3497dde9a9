#pragma once

#include <cmath>

#include "core/math/types.h"

namespace hapton {

// The rotation vector (axis times angle, rad, at most pi long) that turns one orientation into another, along the axes of the frame in
// which both are given. RT: yes.
inline Vec3 turn_between(const Quat& from, const Quat& to) noexcept {
  Quat turn = to * from.conjugate();
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  if (!(sine > 0.0)) return Vec3::Zero();
  return (2.0 * std::atan2(sine, turn.w()) / sine) * turn.vec();
}

// The rotation by a rotation vector. RT: yes.
inline Quat turn_by(const Vec3& turn) noexcept {
  const double angle = turn.norm();
  if (!(angle > 0.0)) return Quat::Identity();
  Quat q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = (std::sin(0.5 * angle) / angle) * turn;
  return q;
}

}  // namespace hapton
