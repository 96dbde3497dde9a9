#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace hapton {

// How LatencyHistogram lays out its buckets: an exponent, then 64 linear sub-buckets; values below 128 ns have a bucket each.
namespace histogram_layout {

constexpr int kSubBucketBits = 6;  // a bucket is at most 1/64 of its value wide
constexpr std::uint64_t kSubBuckets = std::uint64_t{1} << kSubBucketBits;
constexpr std::int64_t kMaxRecordableNs = 100'000'000'000;  // 100 s

constexpr std::size_t bucket_of(std::uint64_t value_ns) noexcept {
  // Shift the value until 64 .. 127 is left.
  const auto octave = static_cast<std::uint64_t>(std::bit_width(value_ns | (2 * kSubBuckets - 1)) - (kSubBucketBits + 1));
  return octave * kSubBuckets + (value_ns >> octave);
}

constexpr std::int64_t lower_ns(std::size_t bucket) noexcept {
  const std::size_t octave = bucket < 2 * kSubBuckets ? 0 : bucket / kSubBuckets - 1;
  return static_cast<std::int64_t>((bucket - octave * kSubBuckets) << octave);
}

}  // namespace histogram_layout

// Counts durations in logarithmic buckets: 64 to an octave, so a bucket is at most 1/64 (1.6 %) wide and a quantile accurate to 0.8 %.
// Units: nanoseconds, 1 ns .. 100 s; a duration outside counts in the first or last bucket (max, min and mean stay exact).
// RT: record, merge and the readers yes. Threads: one writer; share by copy.
// Source: the bucket layout of HdrHistogram (G. Tene): an exponent, then a linear sub-bucket.
class LatencyHistogram {
 public:
  static constexpr std::int64_t kMaxRecordableNs = histogram_layout::kMaxRecordableNs;
  static constexpr std::size_t kBucketCount = histogram_layout::bucket_of(kMaxRecordableNs) + 1;

  void record(std::int64_t duration_ns) noexcept {
    const std::int64_t clamped = duration_ns < 1 ? 1 : duration_ns > kMaxRecordableNs ? kMaxRecordableNs : duration_ns;
    ++buckets_[histogram_layout::bucket_of(static_cast<std::uint64_t>(clamped))];
    ++count_;
    sum_ns_ += static_cast<double>(duration_ns);
    max_ns_ = duration_ns > max_ns_ ? duration_ns : max_ns_;
    min_ns_ = duration_ns < min_ns_ ? duration_ns : min_ns_;
  }

  void merge(const LatencyHistogram& other) noexcept;
  void clear() noexcept { *this = LatencyHistogram(); }

  std::uint64_t count() const noexcept { return count_; }
  std::int64_t max_ns() const noexcept { return count_ == 0 ? 0 : max_ns_; }
  std::int64_t min_ns() const noexcept { return count_ == 0 ? 0 : min_ns_; }
  double mean_ns() const noexcept { return count_ == 0 ? 0.0 : sum_ns_ / static_cast<double>(count_); }

  // The duration that a share of `fraction` (0 .. 1) of the records does not exceed, by nearest rank; 0 when empty.
  double quantile_ns(double fraction) const noexcept;

  // Calls visit(lower_ns, upper_ns, count) for each bucket that is not empty, lowest first; a bucket covers [lower, upper).
  template <class Visit>
  void for_each_bucket(Visit&& visit) const {
    for (std::size_t bucket = 0; bucket < kBucketCount; ++bucket) {
      if (buckets_[bucket] != 0) {
        visit(histogram_layout::lower_ns(bucket), histogram_layout::lower_ns(bucket + 1), buckets_[bucket]);
      }
    }
  }

 private:
  std::array<std::uint64_t, kBucketCount> buckets_ = {};
  std::uint64_t count_ = 0;
  double sum_ns_ = 0.0;
  std::int64_t max_ns_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t min_ns_ = std::numeric_limits<std::int64_t>::max();
};

}  // namespace hapton
