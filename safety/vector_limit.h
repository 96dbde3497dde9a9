#pragma once

#include <cmath>

#include "core/math/types.h"

namespace hapton {

// Keeps rounding from lifting a result above its limit.
constexpr double kJustBelow = 1.0 - 1e-12;

// The length of v; exact for components whose squares overflow or vanish.
inline double length_of(const Vec3& v) noexcept {
  const double squared = v.squaredNorm();
  if (squared > 1e-200 && squared < 1e200) return std::sqrt(squared);
  const double largest = v.cwiseAbs().maxCoeff();
  return largest == 0.0 ? 0.0 : largest * (v / largest).norm();
}

// v, made no longer than `most`; its direction stays. Pre: finite; most >= 0.
inline Vec3 shortened(const Vec3& v, double most) noexcept {
  const double length = length_of(v);
  if (length <= most) return v;
  const double largest = v.cwiseAbs().maxCoeff();
  return (v / largest).normalized() * (most * kJustBelow);
}

}  // namespace hapton
