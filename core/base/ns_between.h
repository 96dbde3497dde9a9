#pragma once

#include <cstdint>
#include <limits>

namespace hapton {

// to_ns - from_ns; where that overflows 64 bits, the nearest limit: times from a file or another program may be any numbers. RT: yes.
constexpr std::int64_t ns_between(std::int64_t from_ns, std::int64_t to_ns) noexcept {
  std::int64_t passed_ns = 0;
  if (!__builtin_sub_overflow(to_ns, from_ns, &passed_ns)) return passed_ns;
  return to_ns < from_ns ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
}

// The same in seconds. RT: yes.
constexpr double seconds_between(std::int64_t from_ns, std::int64_t to_ns) noexcept {
  return 1e-9 * static_cast<double>(ns_between(from_ns, to_ns));
}

}  // namespace hapton
