#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/effects/line_spectrum.h"

namespace hapton {

// The last samples of a signal, for filters with a polynomial C = 1 + c_1 z^-1 + ...:
//   x = e / C:   x = e - history.sum(c); history.push(x)
//   x = C e:     x = e + history.sum(c); history.push(e)
// Coefficients may differ from sample to sample. RT: yes. Threads: one.
class SampleHistory {
 public:
  void reset() noexcept { *this = {}; }

  // c_1 x[n-1] + c_2 x[n-2] + ..., for at most kMaxLines coefficients.
  double sum(std::span<const double> coefficients) const noexcept {
    // Four sums side by side, so that one does not wait for another.
    std::array<double, 4> sums = {};
    const double* past = samples_.data() + newest_;
    std::size_t i = 0;
    for (; i + 4 <= coefficients.size(); i += 4) {
      for (std::size_t k = 0; k < 4; ++k) sums[k] += coefficients[i + k] * past[i + k];
    }
    for (; i < coefficients.size(); ++i) sums[0] += coefficients[i] * past[i];
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
  }
  void push(double sample) noexcept {
    newest_ = (newest_ + kMaxLines - 1) % kMaxLines;
    samples_[newest_] = samples_[newest_ + kMaxLines] = sample;
  }

 private:
  // Every sample is stored twice, so that the last kMaxLines are always in one piece, the newest first.
  std::array<double, 2 * kMaxLines> samples_ = {};
  std::size_t newest_ = 0;
};

}  // namespace hapton
