#pragma once

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

namespace hapton::spectrum {

// The discrete Fourier transform, in place, by halving (radix 2). Pre: x.size() is a power of two.
inline void transform(std::vector<std::complex<double>>& x) {
  const std::size_t n = x.size();
  if (n < 2) return;
  std::vector<std::complex<double>> even(n / 2), odd(n / 2);
  for (std::size_t i = 0; i < n / 2; ++i) {
    even[i] = x[2 * i];
    odd[i] = x[2 * i + 1];
  }
  transform(even);
  transform(odd);
  for (std::size_t i = 0; i < n / 2; ++i) {
    const auto turned = std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n)) * odd[i];
    x[i] = even[i] + turned;
    x[i + n / 2] = even[i] - turned;
  }
}

// One-sided power density in bins of rate / size (Welch 1967), from Hann windows that overlap by half.
inline std::vector<double> density(const std::vector<double>& signal, double rate_hz, std::size_t size) {
  std::vector<double> sum(size / 2 + 1, 0.0);
  double windows = 0.0;
  for (std::size_t begin = 0; begin + size <= signal.size(); begin += size / 2) {
    std::vector<std::complex<double>> part(size);
    for (std::size_t i = 0; i < size; ++i) {
      const double window = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size));
      part[i] = window * signal[begin + i];
    }
    transform(part);
    for (std::size_t k = 0; k <= size / 2; ++k) sum[k] += std::norm(part[k]);
    windows += 1.0;
  }
  // The mean square of the window is 3 / 8.
  for (double& power : sum) power *= 2.0 / (windows * rate_hz * static_cast<double>(size) * 0.375);
  return sum;
}

}  // namespace hapton::spectrum
