#pragma once

#include <cstdint>

namespace hapton {

// In nanoseconds.
inline constexpr std::int64_t kUs = 1000;
inline constexpr std::int64_t kMs = 1'000'000;
inline constexpr std::int64_t kSecond = 1'000'000'000;

}  // namespace hapton
