#pragma once

#include <cmath>

namespace hapton {

// The zero of a continuous function: false position that halves the value at an end that is kept twice in a row (the Illinois method;
// Dowell and Jarratt 1971). The function is `at_low` at `low`, `at_high` at `high`, and `value(t)` between. Stops where |value| <=
// near_zero, where the next estimate rounds to `low` or `high`, after `most_rounds`, or where `value` is NaN (unknown there). Pre: at_high
// < 0. Returns the last estimate, but `low` unless at_low > 0. RT: yes, if `value` is.
template <class Value>
double find_zero(double low, double at_low, double high, double at_high, double near_zero, Value&& value, int most_rounds = 40) {
  if (!(at_low > 0.0)) return low;
  double zero = low;
  double at_previous = 0.0;
  for (int i = 0; i < most_rounds; ++i) {
    zero = low + (high - low) * (at_low / (at_low - at_high));
    if (!(zero > low) || !(zero < high)) break;
    const double at_zero = value(zero);
    if (!(std::fabs(at_zero) > near_zero)) break;
    if (at_zero < 0.0) {
      high = zero;
      at_high = at_zero;
      if (at_previous < 0.0) at_low *= 0.5;
    } else {
      low = zero;
      at_low = at_zero;
      if (at_previous > 0.0) at_high *= 0.5;
    }
    at_previous = at_zero;
  }
  return zero;
}

}  // namespace hapton
