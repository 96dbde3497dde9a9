#include "runtime/latency_histogram.h"

#include <algorithm>
#include <cmath>

namespace hapton {

void LatencyHistogram::merge(const LatencyHistogram& other) noexcept {
  for (std::size_t bucket = 0; bucket < kBucketCount; ++bucket) {
    buckets_[bucket] += other.buckets_[bucket];
  }
  count_ += other.count_;
  sum_ns_ += other.sum_ns_;
  max_ns_ = std::max(max_ns_, other.max_ns_);
  min_ns_ = std::min(min_ns_, other.min_ns_);
}

double LatencyHistogram::quantile_ns(double fraction) const noexcept {
  if (count_ == 0) {
    return 0.0;
  }
  const double clamped = std::isnan(fraction) ? 1.0 : std::clamp(fraction, 0.0, 1.0);
  // 0.07 * 100 is a little above 7 in binary. A product that only rounding lifted above a whole number is brought back below it.
  constexpr double kRounding = 1.0 - 4 * std::numeric_limits<double>::epsilon();
  const auto n = static_cast<double>(count_);
  const auto rank = static_cast<std::uint64_t>(std::clamp(std::ceil(clamped * n * kRounding), 1.0, n));
  if (rank == count_) {
    return static_cast<double>(max_ns_);
  }
  std::uint64_t seen = 0;
  for (std::size_t bucket = 0; bucket < kBucketCount; ++bucket) {
    seen += buckets_[bucket];
    if (seen >= rank) {
      const double middle = 0.5 * static_cast<double>(histogram_layout::lower_ns(bucket) + histogram_layout::lower_ns(bucket + 1) - 1);
      return std::clamp(middle, static_cast<double>(min_ns_), static_cast<double>(max_ns_));
    }
  }
  return static_cast<double>(max_ns_);
}

}  // namespace hapton
