#include "runtime/arrival_forecast.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::int64_t kSenderPeriodNs = 1'000'000;
constexpr std::int64_t kSenderOffsetNs = -5'000'000'000;  // this clock minus the sender's

// Feeds samples of a sender whose datagrams take delay_ns; returns the number of the next sample.
std::uint64_t feed(ArrivalForecast& forecast, std::uint64_t first, std::uint32_t count, std::int64_t delay_ns) {
  for (std::uint64_t n = first; n < first + count; ++n) {
    const auto sample_ns = static_cast<std::int64_t>(n) * kSenderPeriodNs;
    forecast.note(n, sample_ns, sample_ns + kSenderOffsetNs + delay_ns, 1000.0);
  }
  return first + count;
}

TEST(ArrivalForecast, IsAPeriodAndTheShortestDelayAfterTheLastSample) {
  ArrivalForecast forecast;
  std::uint64_t next = feed(forecast, 1, 40, 80'000);
  next = feed(forecast, next, 1, 50'000);
  next = feed(forecast, next, 5, 200'000);
  EXPECT_EQ(forecast.find_next_ns(), static_cast<std::int64_t>(next) * kSenderPeriodNs + kSenderOffsetNs + 50'000);
}

TEST(ArrivalForecast, KnowsNothingBeforeABlockOfSamples) {
  ArrivalForecast forecast;
  EXPECT_FALSE(forecast.find_next_ns());
  const std::uint64_t next = feed(forecast, 1, ArrivalForecast::kDelays - 1, 80'000);
  EXPECT_FALSE(forecast.find_next_ns());
  feed(forecast, next, 1, 80'000);
  EXPECT_TRUE(forecast.find_next_ns());
  forecast.note(ArrivalForecast::kDelays + 1, 0, 0, 0.0);
  EXPECT_FALSE(forecast.find_next_ns());
}

TEST(ArrivalForecast, ASampleThatWasTakenLateDoesNotMoveTheTicks) {
  ArrivalForecast forecast;
  const std::uint64_t next = feed(forecast, 1, 40, 80'000);
  const std::int64_t tick_ns = static_cast<std::int64_t>(next) * kSenderPeriodNs;
  for (const std::int64_t late_ns : {1L, 300'000L, 499'999L}) {
    ArrivalForecast after = forecast;
    after.note(next, tick_ns + late_ns, tick_ns + late_ns + kSenderOffsetNs + 80'000, 1000.0);
    EXPECT_EQ(after.find_next_ns(), tick_ns + kSenderPeriodNs + kSenderOffsetNs + 80'000);
  }
}

TEST(ArrivalForecast, TicksThatMovedForGoodAreFollowed) {
  ArrivalForecast forecast;
  std::uint64_t n = feed(forecast, 1, 40, 80'000);
  std::int64_t tick_ns = 0;
  for (std::uint32_t k = 0; k <= ArrivalForecast::kDelays; ++k, ++n) {
    tick_ns = static_cast<std::int64_t>(n) * kSenderPeriodNs + 300'000;
    forecast.note(n, tick_ns, tick_ns + kSenderOffsetNs + 80'000, 1000.0);
    const bool is_followed = k == ArrivalForecast::kDelays;
    const std::int64_t known_tick_ns = is_followed ? tick_ns : tick_ns - 300'000;
    EXPECT_EQ(forecast.find_next_ns(), known_tick_ns + kSenderPeriodNs + kSenderOffsetNs + 80'000) << k;
  }
  EXPECT_EQ(forecast.find_next_ns(), tick_ns + kSenderPeriodNs + kSenderOffsetNs + 80'000);
}

TEST(ArrivalForecast, ATickThatTheSenderSkippedMovesThem) {
  ArrivalForecast forecast;
  const std::uint64_t next = feed(forecast, 1, 40, 80'000);
  const std::int64_t tick_ns = static_cast<std::int64_t>(next + 3) * kSenderPeriodNs;
  forecast.note(next, tick_ns, tick_ns + kSenderOffsetNs + 80'000, 1000.0);
  EXPECT_EQ(forecast.find_next_ns(), tick_ns + kSenderPeriodNs + kSenderOffsetNs + 80'000);
}

TEST(ArrivalForecast, FollowsADelayThatBecameLongerAfterTwoBlocks) {
  ArrivalForecast forecast;
  std::uint64_t next = feed(forecast, 1, ArrivalForecast::kDelays, 50'000);
  next = feed(forecast, next, 2 * ArrivalForecast::kDelays, 20'000'000);
  EXPECT_EQ(forecast.find_next_ns(), static_cast<std::int64_t>(next) * kSenderPeriodNs + kSenderOffsetNs + 20'000'000);
}

TEST(ArrivalForecast, ForecastsNothingWhileSamplesAreMissing) {
  ArrivalForecast forecast;
  std::uint64_t next = feed(forecast, 1, 100, 50'000);
  next = feed(forecast, next + 15, 1, 50'000);
  EXPECT_FALSE(forecast.find_next_ns());
  feed(forecast, next, 1, 50'000);
  EXPECT_TRUE(forecast.find_next_ns());
}

// Times at the ends of the range that a decoder accepts make the due time arbitrary; later samples correct it.
TEST(ArrivalForecast, RecoversFromTimesOfABrokenSender) {
  constexpr std::int64_t kMaxNs = (std::int64_t{1} << 61) - 1;
  for (const std::int64_t first_ns : {-kMaxNs, kMaxNs}) {
    ArrivalForecast forecast;
    std::uint64_t next = 1;
    for (; next <= 3 * ArrivalForecast::kDelays; ++next) {
      forecast.note(next, next % 2 == 0 ? first_ns : -first_ns, 5'000'000'000, 1000.0);
      const auto due_ns = forecast.find_next_ns();
      EXPECT_EQ(due_ns.has_value(), next >= ArrivalForecast::kDelays);
    }
    next = feed(forecast, next, 2 * ArrivalForecast::kDelays + 1, 50'000);
    EXPECT_EQ(forecast.find_next_ns(), static_cast<std::int64_t>(next) * kSenderPeriodNs + kSenderOffsetNs + 50'000);
  }
}

}  // namespace
}  // namespace hapton
