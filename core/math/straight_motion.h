#pragma once

#include <algorithm>

#include "core/math/types.h"

namespace hapton {

// A point on a straight motion from time 0 to 1; exactly `to` from then on. RT: yes.
inline Vec3 on_way(const Vec3& from, const Vec3& to, double time) { return time < 1.0 ? Vec3(from + time * (to - from)) : to; }

// When a quantity that is `at_0` at time 0 and `at_1` at time 1, and linear between, passes zero, not before `now`. Pre: it does, or has.
// RT: yes.
inline double time_of_zero(double at_0, double at_1, double now) {
  const double t = at_0 != at_1 ? at_0 / (at_0 - at_1) : now;
  return std::clamp(t, now, 1.0);
}

}  // namespace hapton
