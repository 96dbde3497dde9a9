#pragma once

#include <cstdint>

namespace hapton {

// The number `index` of a random sequence: mean 0, variance 1, no correlation between different indices, at most kMaxWhiteNoise in
// magnitude. It depends on seed and index alone, so a sequence repeats bit for bit on every machine, and any part of it can be computed
// alone. RT: yes. Source: SplitMix64 of Steele, Lea and Flood (2014), Fast splittable pseudorandom number generators; the sum of its four
// parts of 16 bits is Gaussian up to an excess kurtosis of -0.3.
constexpr double kMaxWhiteNoise = 3.47;  // sqrt(12), rounded up

inline double white_noise(std::uint64_t seed, std::uint64_t index) noexcept {
  constexpr double kValues = 65536.0;  // number of values of a part
  std::uint64_t z = seed + (index + 1) * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  z ^= z >> 31;
  const auto sum = static_cast<double>((z & 0xFFFF) + ((z >> 16) & 0xFFFF) + ((z >> 32) & 0xFFFF) + (z >> 48));
  // The variance of a part is (kValues^2 - 1) / 12; the difference to kValues^2 / 12 is below 1e-9.
  constexpr double kPerDeviation = 1.7320508075688772 / kValues;
  return (sum - 2.0 * (kValues - 1.0)) * kPerDeviation;
}

}  // namespace hapton
