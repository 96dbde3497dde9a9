#pragma once

#include <algorithm>
#include <cmath>

namespace hapton {

// Narrows the interval from low to high until high - low <= fine * high; returns low. holds: double -> bool, true at low, false at high.
template <class Holds>
double bisect(double low, double high, double fine, const Holds& holds) {
  while (high - low > fine * high) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

struct ValueRange {
  double first = 1.0;       // value at which the search begins; above zero
  double ratio = 1.3;       // ratio of each value tried to the one before; above one
  double least = HUGE_VAL;  // if first fails, the search goes down to this value; above zero; default: it does not go down
  double most = HUGE_VAL;
};

// The largest value up to which `holds` was found true: searched upwards by equal ratios, then by bisection to the relative width `fine`.
// range.most if it holds up to there; zero if it holds at none of the values tried down to range.least.
template <class Holds>
double find_largest_value(const ValueRange& range, double fine, const Holds& holds) {
  double low = 0.0;
  double high = range.first;
  for (; holds(high); high *= range.ratio) {
    low = high;
    if (high > range.most) return range.most;
  }
  while (low == 0.0) {
    if (high <= range.least) return 0.0;
    const double half = 0.5 * high;
    (holds(half) ? low : high) = half;
  }
  return std::min(bisect(low, high, fine, holds), range.most);
}

}  // namespace hapton
