#pragma once

namespace hapton {

// x rounded to single precision. The empty assembly statement keeps the compiler from removing the two conversions: GCC 12 does so where it
// vectorises them (decisions 160 and 207), and then the number stored in single precision differs from the one used. RT: yes.
inline double rounded_to_float(double x) noexcept {
  auto f = static_cast<float>(x);
  asm("" : "+m"(f));
  return static_cast<double>(f);
}

}  // namespace hapton
