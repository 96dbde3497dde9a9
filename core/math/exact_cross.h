#pragma once

#include <cmath>

#include "core/math/types.h"

namespace hapton {

// a*b - c*d within 2 units in the last place, also where digits cancel (algorithm of Kahan; Jeannerod, Louvet & Muller 2013). RT: yes.
inline double difference_of_products(double a, double b, double c, double d) {
  const double cd = c * d;
  const double rounding = std::fma(-c, d, cd);
  return std::fma(a, b, -cd) + rounding;
}

// u x v, each component within 2 units in the last place, so that even the normal of a thin needle keeps its direction. For an exact
// triangle normal the edges u and v must be exact (see TouchGeometry). RT: yes.
inline Vec3 accurate_cross(const Vec3& u, const Vec3& v) {
  return {difference_of_products(u.y(), v.z(), u.z(), v.y()), difference_of_products(u.z(), v.x(), u.x(), v.z()),
          difference_of_products(u.x(), v.y(), u.y(), v.x())};
}

}  // namespace hapton
