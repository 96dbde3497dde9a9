#pragma once

namespace hapton {

// x rounded to single precision. The empty assembly statement keeps the compiler from removing the two conversions: GCC 12 does so where it
// vectorises them (decisions 160 and 207), so that what is stored in single precision and what was computed with are two numbers. RT: yes.
inline double rounded_to_float(double x) noexcept {
  auto f = static_cast<float>(x);
  asm("" : "+m"(f));
  return static_cast<double>(f);
}

}  // namespace hapton
