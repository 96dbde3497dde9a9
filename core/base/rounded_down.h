#pragma once

#include <cmath>

namespace hapton {

// To two digits: what is advised as "or less" is low enough as it is printed ({:.2g}). Pre: x > 0. RT: yes.
inline double rounded_down(double x) noexcept {
  const double digit = std::pow(10.0, std::floor(std::log10(x)) - 1.0);
  constexpr double kRounding = 1e-12;  // a number of two digits stays
  return digit * std::floor(x / digit * (1.0 + kRounding));
}

}  // namespace hapton
