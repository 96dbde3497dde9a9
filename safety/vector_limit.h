#pragma once

#include <cmath>

#include "core/math/types.h"

namespace hapton {

// Factor on a limit, so that a rounded result never exceeds it: the margin is far above rounding (1e-15) and too small to be felt.
constexpr double kJustBelow = 1.0 - 1e-12;

// The length of v, also where the squares of its components overflow or vanish. RT: yes.
inline double length_of(const Vec3& v) noexcept {
  const double squared = v.squaredNorm();
  if (squared > 1e-200 && squared < 1e200) return std::sqrt(squared);
  const double largest = v.cwiseAbs().maxCoeff();
  return largest == 0.0 ? 0.0 : largest * (v / largest).norm();
}

// v, shortened to the length `most` if it is longer, with the same direction. Pre: v is finite; most >= 0. RT: yes.
inline Vec3 shortened(const Vec3& v, double most) noexcept {
  const double length = length_of(v);
  if (length <= most) return v;
  const double largest = v.cwiseAbs().maxCoeff();
  return (v / largest).normalized() * (most * kJustBelow);
}

}  // namespace hapton
