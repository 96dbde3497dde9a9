#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace hapton {

// Reads a signal with samples at regular times at any other times: a sum of the samples around, weighted by a windowed sinc (Kaiser). The
// spectrum read is that of the samples, within 0.2 dB up to 0.9 f, with f half the rate of the samples divided by the stride; from 1.1 f
// on, images and aliases are 40 dB lower. With stride 1, read at times of samples, it is the samples to the last bit. The signal is read
// find_delay(stride) samples late. Units: samples. RT: yes, but for the first object, which makes a table. Threads: one.
// Source: Smith and Gossett (1984), A flexible sampling-rate conversion method, ICASSP.
class BandLimitedSignal {
 public:
  static constexpr std::size_t kHalfWidth = 12;
  static constexpr double kMaxStride = 10.0;
  // The largest ratio of the rates to the stride that is chosen for it: rates that vary a little need no larger stride. What the readings
  // cannot carry is then folded into the highest fifth of their band only.
  static constexpr double kMostAboveStride = 1.1;

  BandLimitedSignal() noexcept;

  // Sets all samples to zero.
  void reset() noexcept;
  void push(double sample) noexcept;
  // The stride for at(), 1 to kMaxStride. samples_per_reading: the rate of the samples divided by that of the readings.
  static double stride_for(double samples_per_reading) noexcept;
  // At least kHalfWidth * stride, rounded up.
  static std::size_t find_delay(double stride) noexcept;
  // The signal at `since_newest` samples (0 to 1) after the newest one, less find_delay(stride) samples. stride: from stride_for.
  double at(double since_newest, double stride) const noexcept;

 private:
  // Every sample is stored twice, so that the last kStored are always in one piece.
  static constexpr std::size_t kStored = 256;
  static_assert(static_cast<double>(kStored) >= 2 * kHalfWidth * kMaxStride);

  std::array<double, 2 * kStored> samples_ = {};
  std::size_t next_ = 0;
  const double* kernel_;
};

}  // namespace hapton
