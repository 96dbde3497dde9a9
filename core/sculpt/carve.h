#pragma once

#include "core/math/rounded_to_float.h"
#include "core/math/types.h"

namespace hapton {

// The capsule of material that a ball removes along a straight path. Frame: that of the field (the static scene S). Units: metres.
struct Carve {
  Vec3 from_m = Vec3::Zero();  // the ball's centre at the beginning of the path
  Vec3 to_m = Vec3::Zero();    // the ball's centre at its end
  double radius_m = 0.0;

  friend bool operator==(const Carve& a, const Carve& b) { return a.from_m == b.from_m && a.to_m == b.to_m && a.radius_m == b.radius_m; }
};

// The carve with all numbers rounded to single precision. CarvedField::carve does this first, so that two processes with the same list of
// carves have the same field to the last bit. RT: yes.
inline Carve rounded(const Carve& carve) noexcept {
  const auto each = [](const Vec3& p) { return Vec3(rounded_to_float(p.x()), rounded_to_float(p.y()), rounded_to_float(p.z())); };
  return {each(carve.from_m), each(carve.to_m), rounded_to_float(carve.radius_m)};
}

}  // namespace hapton
