#include "runtime/latency_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace hapton {
namespace {

constexpr double kResolution = 1.0 / 128;  // half a bucket

double exact_quantile(std::vector<std::int64_t> values, double fraction) {
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(values.size())));
  return static_cast<double>(values[std::max<std::size_t>(rank, 1) - 1]);
}

TEST(LatencyHistogramTest, EmptyIsAllZero) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.quantile_ns(0.5), 0.0);
  EXPECT_EQ(histogram.max_ns(), 0);
  EXPECT_EQ(histogram.min_ns(), 0);
  EXPECT_EQ(histogram.mean_ns(), 0.0);
}

TEST(LatencyHistogramTest, SmallValuesAreExact) {
  LatencyHistogram histogram;
  for (std::int64_t value = 1; value <= 100; ++value) {
    histogram.record(value);
  }
  for (int percent = 1; percent <= 100; ++percent) {
    EXPECT_EQ(histogram.quantile_ns(percent / 100.0), percent);
  }
  EXPECT_EQ(histogram.mean_ns(), 50.5);
}

TEST(LatencyHistogramTest, QuantilesAgreeWithSorting) {
  constexpr std::uint64_t kSeed = 3;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  for (const double spread : {0.1, 1.0, 3.0}) {
    std::lognormal_distribution<double> latency(std::log(20e3), spread);
    LatencyHistogram histogram;
    std::vector<std::int64_t> values;
    double sum = 0.0;
    for (int i = 0; i < 50'000; ++i) {
      values.push_back(std::clamp<std::int64_t>(static_cast<std::int64_t>(latency(random)), 1, LatencyHistogram::kMaxRecordableNs));
      histogram.record(values.back());
      sum += static_cast<double>(values.back());
    }
    for (const double fraction : {0.0, 0.01, 0.5, 0.9, 0.99, 0.999, 0.9999, 1.0}) {
      const double exact = exact_quantile(values, fraction);
      EXPECT_NEAR(histogram.quantile_ns(fraction), exact, kResolution * exact + 0.5) << "spread " << spread << " q " << fraction;
    }
    EXPECT_EQ(histogram.max_ns(), *std::max_element(values.begin(), values.end()));
    EXPECT_EQ(histogram.min_ns(), *std::min_element(values.begin(), values.end()));
    EXPECT_NEAR(histogram.mean_ns(), sum / 50'000, 1e-9 * sum);
  }
}

TEST(LatencyHistogramTest, BucketsTileTheRangeFinely) {
  for (std::size_t bucket = 1; bucket < LatencyHistogram::kBucketCount; ++bucket) {
    const auto lower = static_cast<std::uint64_t>(histogram_layout::lower_ns(bucket));
    const auto upper = static_cast<std::uint64_t>(histogram_layout::lower_ns(bucket + 1));
    ASSERT_LT(lower, upper);
    ASSERT_EQ(histogram_layout::bucket_of(lower), bucket);
    ASSERT_EQ(histogram_layout::bucket_of(upper - 1), bucket);
    if (upper - lower > 1) {
      ASSERT_LE(static_cast<double>(upper - lower), static_cast<double>(lower) / 64);
    }
  }
}

TEST(LatencyHistogramTest, ValuesOutsideTheRangeCountAtItsEnds) {
  LatencyHistogram histogram;
  for (const std::int64_t value : {std::int64_t{-5}, std::int64_t{0}, std::numeric_limits<std::int64_t>::max()}) {
    histogram.record(value);
  }
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_EQ(histogram.max_ns(), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(histogram.min_ns(), -5);
  std::uint64_t counted = 0;
  histogram.for_each_bucket([&](std::int64_t, std::int64_t, std::uint64_t count) { counted += count; });
  EXPECT_EQ(counted, 3U);
}

TEST(LatencyHistogramTest, MergingEqualsRecordingTogether) {
  std::mt19937_64 random(1);
  LatencyHistogram first;
  LatencyHistogram second;
  LatencyHistogram both;
  for (int i = 0; i < 1000; ++i) {
    const auto value = static_cast<std::int64_t>(random() % 1'000'000);
    (i % 3 == 0 ? first : second).record(value);
    both.record(value);
  }
  first.merge(second);
  EXPECT_EQ(first.count(), both.count());
  EXPECT_EQ(first.max_ns(), both.max_ns());
  EXPECT_EQ(first.min_ns(), both.min_ns());
  EXPECT_DOUBLE_EQ(first.mean_ns(), both.mean_ns());
  for (const double fraction : {0.1, 0.5, 0.99}) {
    EXPECT_EQ(first.quantile_ns(fraction), both.quantile_ns(fraction));
  }
  first.merge(LatencyHistogram());
  EXPECT_EQ(first.min_ns(), both.min_ns());
  first.clear();
  EXPECT_EQ(first.count(), 0U);
}

TEST(LatencyHistogramTest, VisitsBucketsInOrderWithTheirValues) {
  LatencyHistogram histogram;
  histogram.record(1000);
  histogram.record(1000);
  histogram.record(50);
  std::vector<std::uint64_t> counts;
  histogram.for_each_bucket([&](std::int64_t lower, std::int64_t upper, std::uint64_t count) {
    const std::int64_t value = counts.empty() ? 50 : 1000;
    EXPECT_LE(lower, value);
    EXPECT_GT(upper, value);
    counts.push_back(count);
  });
  EXPECT_EQ(counts, (std::vector<std::uint64_t>{1, 2}));
}

}  // namespace
}  // namespace hapton
