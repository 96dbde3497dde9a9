#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace hapton {

// From one to the next at that rate; at most 31 years, to which a time can be added. Pre: rate_hz > 0. RT: yes.
inline std::int64_t period_ns(double rate_hz) noexcept {
  constexpr double kLongestNs = 1e18;  // 31 years: a time of 64 bits reaches 292
  return std::llround(std::min(1e9 / rate_hz, kLongestNs));
}

}  // namespace hapton
