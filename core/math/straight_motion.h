#pragma once

#include <algorithm>

#include "core/math/types.h"

namespace hapton {

// The point at `time` of a straight motion that lasts from time 0 to 1; exactly `to` from 1 on. RT: yes.
inline Vec3 on_path(const Vec3& from, const Vec3& to, double time) { return time < 1.0 ? Vec3(from + time * (to - from)) : to; }

// The time at which a quantity that is `at_0` at time 0, `at_1` at time 1 and linear between passes zero; `now` if that was earlier. Pre:
// it has passed zero or will by time 1; now <= 1. RT: yes.
inline double time_of_zero(double at_0, double at_1, double now) {
  const double t = at_0 != at_1 ? at_0 / (at_0 - at_1) : now;
  return std::clamp(t, now, 1.0);
}

}  // namespace hapton
