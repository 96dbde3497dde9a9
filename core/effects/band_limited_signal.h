#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hapton {

// Reads a signal that has samples at regular times at any other times: the sum of the samples around, weighted by a sinc function with a
// Kaiser window. The spectrum of what is read is that of the samples, within 0.2 dB up to 0.9 of half the lower rate of the two; from 1.1
// of it on, images and aliases are 40 dB lower. Read at the rate of the samples, at times of samples, it is the samples to the last bit.
// The signal is read kHalfWidth samples of the lower rate late. Units: samples. RT: yes. Threads: one.
// Source: Smith and Gossett (1984), A flexible sampling-rate conversion method, ICASSP.
class BandLimitedSignal {
 public:
  static constexpr std::size_t kHalfWidth = 12;
  static constexpr std::size_t kMaxStride = 10;

  BandLimitedSignal() noexcept;

  // All samples are zero.
  void reset() noexcept;
  void push(double sample) noexcept;
  // samples_per_reading: the rate of the samples over that of reading.
  static std::size_t stride_for(double samples_per_reading) noexcept;
  // At `since_newest` after the newest sample, 0 to 1, less kHalfWidth * stride. stride: of stride_for.
  double at(double since_newest, std::size_t stride) const noexcept;

 private:
  // Every sample twice, so that the last kKept always are in one piece.
  static constexpr std::size_t kKept = 256;
  static_assert(kKept >= 2 * kHalfWidth * kMaxStride);

  std::array<double, 2 * kKept> samples_ = {};
  std::size_t next_ = 0;
  const double* kernel_;
};

}  // namespace hapton
