#pragma once

#include <cmath>
#include <limits>

namespace hapton {

// The first t >= 0 at which a t^2 + 2 b t + c rises above zero. If it is zero or more and rises at t = 0: at once. If it falls: when it
// rises again, or, if it stays above zero, when it is back at its value at t = 0. A dip that stays above zero, or does not go below it by
// more than `play`, is ignored. Infinite if it never rises. RT: yes.
inline double time_of_rise(double a, double b, double c, double play = -std::numeric_limits<double>::infinity()) noexcept {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (a < 0.0 && b > 0.0 && c - b * b / a <= play) return kInfinity;
  if (!(c < 0.0)) {
    if (b > 0.0 || (b == 0.0 && a > 0.0)) return 0.0;
    if (!(a > 0.0)) return kInfinity;
    const double discriminant = b * b - a * c;
    return (discriminant >= 0.0 ? std::sqrt(discriminant) - b : -2.0 * b) / a;
  }
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0.0)) return kInfinity;
  const double root = std::sqrt(discriminant);
  if (b > 0.0) return -c / (b + root);
  return a > 0.0 ? (root - b) / a : kInfinity;
}

}  // namespace hapton
