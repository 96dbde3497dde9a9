#include "core/effects/band_limited_signal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hapton {
namespace {

constexpr std::size_t kWidth = BandLimitedSignal::kHalfWidth;
// Table entries from one zero of the sinc function to the next; divided by each stride, it is a whole number. Linear interpolation is exact
// to 3e-5.
constexpr std::size_t kEntriesPerZero = 120;
constexpr std::array kStrides = {1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0};
// Several sums side by side, so that an addition does not wait for the one before it.
constexpr std::size_t kSums = 4;
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
  // From the kernel's middle to its end, and zeros for as many samples as kSums may need more.
  std::array<double, (kWidth + kSums)* kEntriesPerZero + 2> values = {};

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
double wing(const double* kernel, double from, double stride, const double* samples, std::ptrdiff_t direction) noexcept {
  const auto step = static_cast<std::size_t>(kEntriesPerZero / stride);
  const std::size_t count = BandLimitedSignal::find_delay(stride);
  const double place = from * static_cast<double>(step);
  const auto entry = static_cast<std::size_t>(place);
  const double fraction = place - static_cast<double>(entry);
  const double* first_weight = kernel + entry;
  std::array<double, kSums> sums = {};
  for (std::size_t j = 0; j < count; j += kSums) {
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

double BandLimitedSignal::stride_for(double samples_per_reading) noexcept {
  const auto* found =
      std::find_if(kStrides.begin(), kStrides.end(), [&](double stride) { return kMostAboveStride * stride >= samples_per_reading; });
  return found == kStrides.end() ? kMaxStride : *found;
}

std::size_t BandLimitedSignal::find_delay(double stride) noexcept {
  const auto samples = static_cast<std::size_t>(kWidth * stride);  // whole for each stride
  return (samples + kSums - 1) / kSums * kSums;
}

double BandLimitedSignal::at(double since_newest, double stride) const noexcept {
  // The newest sample has the index next_ + kStored - 1. The middle of the kernel is at the sample `middle`, or between it and the next
  // one.
  const double* middle = samples_.data() + next_ + kStored - 1 - find_delay(stride);
  const double sum = wing(kernel_, since_newest, stride, middle, -1) + wing(kernel_, 1.0 - since_newest, stride, middle + 1, 1);
  return sum / stride;
}

}  // namespace hapton
