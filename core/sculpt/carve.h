#pragma once

#include "core/math/types.h"

namespace hapton {

// Material that a ball removes along a straight path: a capsule. Frame: that of the field (the static scene S). Units: metres.
struct Carve {
  Vec3 from_m = Vec3::Zero();  // the ball's centre at the beginning
  Vec3 to_m = Vec3::Zero();    // ... and at the end
  double radius_m = 0.0;

  friend bool operator==(const Carve& a, const Carve& b) { return a.from_m == b.from_m && a.to_m == b.to_m && a.radius_m == b.radius_m; }
};

// The nearest number that a float can hold, as messages carry it. The empty assembly keeps the compiler from joining the two conversions:
// GCC 12 at -O3 drops both in the rest of a vectorised loop. RT: yes.
inline double rounded_to_float(double x) noexcept {
  auto f = static_cast<float>(x);
  asm("" : "+m"(f));
  return static_cast<double>(f);
}

// The same with numbers that a float can hold. CarvedField::carve does so first: all who carve the same list have the same field to the
// last bit. RT: yes.
inline Carve rounded(const Carve& carve) noexcept {
  const auto each = [](const Vec3& p) { return Vec3(rounded_to_float(p.x()), rounded_to_float(p.y()), rounded_to_float(p.z())); };
  return {each(carve.from_m), each(carve.to_m), rounded_to_float(carve.radius_m)};
}

}  // namespace hapton
