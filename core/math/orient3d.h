#pragma once

#include <cmath>

#include "core/math/types.h"

namespace hapton {

// The exact arithmetic behind orient3d and orient3d_sign: the determinant of the given points as an exact sum, of which the result has the
// sign and all but the last few bits. RT: yes (no heap, about 2 us).
double orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) noexcept;

namespace detail {

// det(b - a, c - a, d - a) in plain doubles; kDeterminantError * size is a bound on its error.
struct RoundedDeterminant {
  double value;
  double size;  // product of the largest |x|, |y| and |z| of the three differences
};

inline RoundedDeterminant rounded_determinant(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a;
  const Vec3 v = c - a;
  const Vec3 w = d - a;
  const Vec3 largest = u.cwiseAbs().cwiseMax(v.cwiseAbs()).cwiseMax(w.cwiseAbs());
  const double value = u.cross(v).dot(w);
  return {value, largest.x() * largest.y() * largest.z()};
}

// The determinant has six products of one difference in each of x, y and z; each carries three roundings of differences and five of its
// own, so the error is at most 6 * 8 * 2^-53 * size, with room for the rounding of size: 2^-47 * size.
constexpr double kDeterminantError = 0x1p-47;

}  // namespace detail

// A determinant in plain doubles larger than this times its size has a relative error below 2^-20.
constexpr double kAccurateDeterminant = 0x1p20 * detail::kDeterminantError;

// Six times the signed volume of tetrahedron abcd, det(b - a, c - a, d - a): > 0 if d is on the side of abc from which a, b, c run
// counter-clockwise; exactly 0 only if the four points are coplanar as given. Relative error at most 2^-20, mostly about 2^-50: plain
// doubles where their error bound allows it, otherwise exact. Pre: coordinates zero or of magnitude 1e-60 .. 1e60. RT: yes. Source:
// Shewchuk 1997 (exact expansions); we differ in having two stages only, the first with a bound from the largest differences.
inline double orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) noexcept {
  const detail::RoundedDeterminant rounded = detail::rounded_determinant(a, b, c, d);
  return std::fabs(rounded.value) > kAccurateDeterminant * rounded.size ? rounded.value : orient3d_exact(a, b, c, d);
}

// The same, but only the sign of the result is meaningful: exact arithmetic only where the sign is in doubt. RT: yes.
inline double orient3d_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) noexcept {
  const detail::RoundedDeterminant rounded = detail::rounded_determinant(a, b, c, d);
  return std::fabs(rounded.value) > detail::kDeterminantError * rounded.size ? rounded.value : orient3d_exact(a, b, c, d);
}

}  // namespace hapton
