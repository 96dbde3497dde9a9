#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace hapton {

// The time between two events at this rate, at most 31 years: added to a time, it does not overflow. Pre: rate_hz > 0. RT: yes.
inline std::int64_t period_ns(double rate_hz) noexcept {
  constexpr double kLongestNs = 1e18;  // 31 years; 64 bits of nanoseconds last for 292
  return std::llround(std::min(1e9 / rate_hz, kLongestNs));
}

}  // namespace hapton
