#pragma once

#include <algorithm>
#include <cmath>

namespace hapton {

// Narrows low < high down to high - low <= fine * high and returns low. holds: double -> bool, true at low, false at high.
template <class Holds>
double bisect(double low, double high, double fine, const Holds& holds) {
  while (high - low > fine * high) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

struct ValueRange {
  double first = 1.0;       // above zero; where the search begins
  double stride = 1.3;      // above one; ratio of one value tried to the next
  double least = HUGE_VAL;  // above zero; if first fails, the search goes down to this; default: not at all
  double most = HUGE_VAL;
};

// The largest value up to which `holds` was found true: searched upwards by equal ratios, then by bisection to the relative `fine`.
// range.most if it holds up to there; zero if it fails at range.least.
template <class Holds>
double find_largest_value(const ValueRange& range, double fine, const Holds& holds) {
  double low = 0.0;
  double high = range.first;
  for (; holds(high); high *= range.stride) {
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
