#pragma once

#include <cmath>
#include <limits>

namespace hapton {

// The first t >= 0 at which f(t) = a t^2 + 2 b t + c rises above zero; infinite if it never does. If f(0) >= 0 and f rises at 0: 0. If
// f(0) >= 0 and f falls at 0: the time at which it rises above zero again, or, if it stays above zero, is back at f(0). A rise to a maximum
// of at most `play` is ignored. RT: yes.
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
