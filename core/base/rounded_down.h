#pragma once

#include <cmath>

namespace hapton {

// x rounded down to two digits: printed with {:.2g}, advice to use this value "or less" does not exceed x. Pre: x > 0. RT: yes.
inline double rounded_down(double x) noexcept {
  const double digit = std::pow(10.0, std::floor(std::log10(x)) - 1.0);
  constexpr double kRounding = 1e-12;  // so that a number that already has two digits is not lowered
  return digit * std::floor(x / digit * (1.0 + kRounding));
}

}  // namespace hapton
