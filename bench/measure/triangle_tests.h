#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/types.h"

namespace hapton {

template <class Real>
using Point3 = Eigen::Matrix<Real, 3, 1>;

// The position at which the segment from p along `motion` meets triangle abc from either side, as a share of `motion`, 0..1; infinity if it
// does not. By Möller & Trumbore 1997, boundary included, with plain rounding: the simple test that every structure here uses, so that
// structures are compared and not triangle tests.
template <class Real>
Real segment_hit(const Point3<Real>& p, const Point3<Real>& motion, const Point3<Real>& a, const Point3<Real>& b, const Point3<Real>& c) {
  constexpr Real kNone = std::numeric_limits<Real>::infinity();
  const Point3<Real> ab = b - a;
  const Point3<Real> ac = c - a;
  const Point3<Real> motion_x_ac = motion.cross(ac);
  const Real determinant = ab.dot(motion_x_ac);
  if (determinant == Real(0)) return kNone;
  const Real inverse = Real(1) / determinant;
  const Point3<Real> ap = p - a;
  const Real u = ap.dot(motion_x_ac) * inverse;
  if (!(u >= Real(0) && u <= Real(1))) return kNone;
  const Point3<Real> ap_x_ab = ap.cross(ab);
  const Real v = motion.dot(ap_x_ab) * inverse;
  if (!(v >= Real(0) && u + v <= Real(1))) return kNone;
  const Real t = ac.dot(ap_x_ab) * inverse;
  return t >= Real(0) && t <= Real(1) ? t : kNone;
}

// The squared distance from p to the segment from a along ab.
template <class Real>
Real edge_distance_squared(const Point3<Real>& p, const Point3<Real>& a, const Point3<Real>& ab) {
  const Real length = ab.squaredNorm();
  const Real t = length > Real(0) ? std::clamp((p - a).dot(ab) / length, Real(0), Real(1)) : Real(0);
  return (p - a - t * ab).squaredNorm();
}

// The squared distance from p to triangle abc.
template <class Real>
Real point_distance_squared(const Point3<Real>& p, const Point3<Real>& a, const Point3<Real>& b, const Point3<Real>& c) {
  const Point3<Real> ab = b - a;
  const Point3<Real> ac = c - a;
  const Point3<Real> n = ab.cross(ac);
  const Real n2 = n.squaredNorm();
  const Point3<Real> ap = p - a;
  if (n2 > Real(0)) {
    const Real v = ap.cross(ac).dot(n) / n2;
    const Real w = ab.cross(ap).dot(n) / n2;
    if (v >= Real(0) && w >= Real(0) && v + w <= Real(1)) {
      const Real height = ap.dot(n);
      return height * height / n2;
    }
  }
  return std::min({edge_distance_squared<Real>(p, a, ab), edge_distance_squared<Real>(p, a, ac), edge_distance_squared<Real>(p, b, c - b)});
}

}  // namespace hapton
