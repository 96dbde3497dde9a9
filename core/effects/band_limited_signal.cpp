#include "core/effects/band_limited_signal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hapton {
namespace {

constexpr std::size_t kWidth = BandLimitedSignal::kHalfWidth;
// Table entries from one zero of the sinc function to the next, a multiple of every stride. Linear interpolation is exact to 3e-5.
constexpr std::size_t kEntriesPerZero = 120;
constexpr std::array<std::size_t, 8> kStrides = {1, 2, 3, 4, 5, 6, 8, 10};
// Shape of the Kaiser window: 41 dB, with a transition of 0.1 of the sample rate over 24 samples (Kaiser and Schafer 1980).
constexpr double kShape = 3.5;

// The modified Bessel function of the first kind and order 0, by its power series.
double bessel_i0(double x) noexcept {
  double term = 1.0;
  double sum = 1.0;
  for (int k = 1; k < 40; ++k) {
    term *= 0.25 * x * x / (k * k);
    sum += term;
  }
  return sum;
}

struct Kernel {
  std::array<double, kWidth* kEntriesPerZero + 2> values = {};  // from the kernel's middle to its end, where it is zero

  Kernel() noexcept {
    values[0] = 1.0;
    for (std::size_t i = 1; i < kWidth * kEntriesPerZero; ++i) {
      if (i % kEntriesPerZero == 0) continue;
      const double x = static_cast<double>(i) / kEntriesPerZero;
      const double share = x / kWidth;
      const double window = bessel_i0(kShape * std::sqrt(1.0 - share * share)) / bessel_i0(kShape);
      values[i] = window * std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
    }
  }
};

// The weighted sum over one side of the kernel: samples[j * direction] has the weight at the distance j + from. from: 0 to 1.
double wing(const double* kernel, double from, std::size_t stride, const double* samples, std::ptrdiff_t direction) noexcept {
  const std::size_t step = kEntriesPerZero / stride;
  const double place = from * static_cast<double>(step);
  const auto entry = static_cast<std::size_t>(place);
  const double fraction = place - static_cast<double>(entry);
  const double* first_weight = kernel + entry;
  // Several sums side by side, so that an addition does not wait for the one before it.
  constexpr std::size_t kSums = 4;
  static_assert(kWidth % kSums == 0);
  std::array<double, kSums> sums = {};
  for (std::size_t j = 0; j < kWidth * stride; j += kSums) {
    for (std::size_t k = 0; k < kSums; ++k) {
      const double* weight = first_weight + (j + k) * step;
      sums[k] += samples[static_cast<std::ptrdiff_t>(j + k) * direction] * (weight[0] + fraction * (weight[1] - weight[0]));
    }
  }
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace

BandLimitedSignal::BandLimitedSignal() noexcept {
  static const Kernel kernel;
  kernel_ = kernel.values.data();
}

void BandLimitedSignal::reset() noexcept {
  samples_.fill(0.0);
  next_ = 0;
}

void BandLimitedSignal::push(double sample) noexcept {
  samples_[next_] = samples_[next_ + kStored] = sample;
  next_ = (next_ + 1) % kStored;
}

std::size_t BandLimitedSignal::stride_for(double samples_per_reading) noexcept {
  const double nearest = std::round(samples_per_reading);
  const auto* found =
      std::find_if(kStrides.begin(), kStrides.end(), [&](std::size_t stride) { return static_cast<double>(stride) >= nearest; });
  return found == kStrides.end() ? kMaxStride : *found;
}

double BandLimitedSignal::at(double since_newest, std::size_t stride) const noexcept {
  // The newest sample has the index next_ + kStored - 1. The middle of the kernel is at the sample `middle`, or between it and the next
  // one.
  const double* middle = samples_.data() + next_ + kStored - 1 - kWidth * stride;
  const double sum = wing(kernel_, since_newest, stride, middle, -1) + wing(kernel_, 1.0 - since_newest, stride, middle + 1, 1);
  return sum / static_cast<double>(stride);
}

}  // namespace hapton
