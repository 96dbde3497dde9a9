#pragma once

#include <cstddef>
#include <span>

namespace hapton {

// The largest number of line spectral frequencies of a polynomial.
constexpr std::size_t kMaxLines = 32;

// A polynomial C(z) = 1 + c_1 z^-1 + ... + c_p z^-p by the cosines of its line spectral frequencies w_1 < ... < w_p: C = (P + Q) / 2, where
// P and Q have all zeros on the unit circle:
//   p even: Q = (1 + z^-1) prod (1 - 2 cos w_i z^-1 + z^-2), i = 1, 3, ...;   P = (1 - z^-1) prod of i = 2, 4, ...
//   p odd:  Q =            prod (1 - 2 cos w_i z^-1 + z^-2), i = 1, 3, ...;   P = (1 - z^-2) prod of i = 2, 4, ...
// If 0 < w_1 < ... < w_p < pi, all zeros of C are inside the unit circle, so the filter 1 / C is stable. A weighted mean of several such
// sequences is one as well: filters that are interpolated by their line spectral frequencies are stable.
// Source: Itakura (1975), Line spectrum representation of linear predictor coefficients of speech signals; Soong and Juang (1984), Line
// spectrum pair (LSP) and speech data compression, ICASSP.
struct LineSpectrum {
  std::span<const double> cosines;  // at most kMaxLines
  std::span<double> coefficients;   // receives c_1 to c_p: as many as cosines
};

// Writes the coefficients of two polynomials, which takes as long as those of one. RT: yes.
void multiply_out(const LineSpectrum& first, const LineSpectrum& second) noexcept;

}  // namespace hapton
