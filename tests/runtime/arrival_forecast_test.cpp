#include "runtime/arrival_forecast.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::int64_t kSenderPeriodNs = 1'000'000;
constexpr std::int64_t kSenderOffsetNs = -5'000'000'000;  // of this clock to the sender's

// Samples of a sender whose datagrams take delay_ns; returns the number of the next one.
std::uint64_t feed(ArrivalForecast& forecast, std::uint64_t first, std::uint32_t count, std::int64_t delay_ns) {
  for (std::uint64_t n = first; n < first + count; ++n) {
    const auto sample_ns = static_cast<std::int64_t>(n) * kSenderPeriodNs;
    forecast.note(n, sample_ns, sample_ns + kSenderOffsetNs + delay_ns);
  }
  return first + count;
}

TEST(ArrivalForecast, IsAPeriodAndTheShortestDelayAfterTheLastSample) {
  ArrivalForecast forecast;
  std::uint64_t next = feed(forecast, 1, 40, 80'000);
  next = feed(forecast, next, 1, 50'000);
  next = feed(forecast, next, 5, 200'000);
  EXPECT_EQ(forecast.find_next_ns(1000.0), static_cast<std::int64_t>(next) * kSenderPeriodNs + kSenderOffsetNs + 50'000);
}

TEST(ArrivalForecast, KnowsNothingBeforeABlockOfSamples) {
  ArrivalForecast forecast;
  EXPECT_FALSE(forecast.find_next_ns(1000.0));
  const std::uint64_t next = feed(forecast, 1, ArrivalForecast::kDelays - 1, 80'000);
  EXPECT_FALSE(forecast.find_next_ns(1000.0));
  feed(forecast, next, 1, 80'000);
  EXPECT_TRUE(forecast.find_next_ns(1000.0));
  EXPECT_FALSE(forecast.find_next_ns(0.0));
}

TEST(ArrivalForecast, FollowsADelayThatBecameLongerAfterTwoBlocks) {
  ArrivalForecast forecast;
  std::uint64_t next = feed(forecast, 1, ArrivalForecast::kDelays, 50'000);
  next = feed(forecast, next, 2 * ArrivalForecast::kDelays, 20'000'000);
  EXPECT_EQ(forecast.find_next_ns(1000.0), static_cast<std::int64_t>(next) * kSenderPeriodNs + kSenderOffsetNs + 20'000'000);
}

TEST(ArrivalForecast, HasNoneWhereSamplesAreLeftOut) {
  ArrivalForecast forecast;
  std::uint64_t next = feed(forecast, 1, 100, 50'000);
  next = feed(forecast, next + 15, 1, 50'000);
  EXPECT_FALSE(forecast.find_next_ns(1000.0));
  feed(forecast, next, 1, 50'000);
  EXPECT_TRUE(forecast.find_next_ns(1000.0));
}

}  // namespace
}  // namespace hapton
