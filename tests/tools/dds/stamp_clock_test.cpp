#include "tools/dds/stamp_clock.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton::dds {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kDayOffset = 1'700'000'000'000'000'000;

TEST(StampClock, OnTheHubsHostAStampIsTheTimeOfTheSample) {
  StampClock clock(true);
  for (std::int64_t i = 1; i < 100; ++i) EXPECT_EQ(clock.stamp_ns(i * kMs, i * kMs + i % 7 * 10'000, kDayOffset), i * kMs + kDayOffset);
}

// The hub's clock is 5 s ahead of ours, and a state takes 0.2 to 3 ms to arrive.
TEST(StampClock, FromAnotherHostAStampIsLateByTheFastestWay) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<std::int64_t> transfer_ns(200'000, 3 * kMs);
    StampClock clock(false);
    const std::int64_t hub_ahead_ns = 5'000 * kMs;
    std::int64_t last = 0;
    for (std::int64_t i = 1; i < 30'000; ++i) {
      const std::int64_t sample_ns = i * kMs;
      const std::int64_t stamp = clock.stamp_ns(sample_ns + hub_ahead_ns, sample_ns + transfer_ns(random), kDayOffset);
      EXPECT_GT(stamp, last) << seed;
      last = stamp;
      if (i < 1'000) continue;
      EXPECT_GE(stamp - kDayOffset - sample_ns, 200'000) << seed;
      EXPECT_LE(stamp - kDayOffset - sample_ns, 300'000) << seed;
    }
  }
}

TEST(StampClock, AClockThatDriftsAwayIsFollowedWithinTwoWindows) {
  StampClock clock(false);
  std::int64_t stamp = 0;
  std::int64_t sample_ns = 0;
  // Our clock gains 1 ms in 10 s: with the fastest transfer of an old window the stamps would fall behind more and more.
  for (std::int64_t i = 1; i < 100'000; ++i) {
    sample_ns = i * kMs;
    stamp = clock.stamp_ns(sample_ns - i * 100, sample_ns, 0);
  }
  EXPECT_LE(sample_ns - stamp, 2 * kMs + 1'000);
  EXPECT_LE(stamp, sample_ns);
}

TEST(StampClock, StampsIncreaseWhateverTheTimeOfDayDoes) {
  StampClock clock(true);
  const std::int64_t first = clock.stamp_ns(1'000 * kMs, 1'000 * kMs, kDayOffset);
  // If the time of day is set back by 0.5 s, the stamps wait for it; if by an hour, they follow it.
  EXPECT_EQ(clock.stamp_ns(1'001 * kMs, 1'001 * kMs, kDayOffset - 500 * kMs), first + 1);
  EXPECT_EQ(clock.stamp_ns(1'002 * kMs, 1'002 * kMs, kDayOffset - 3'600'000 * kMs), 1'002 * kMs + kDayOffset - 3'600'000 * kMs);
}

}  // namespace
}  // namespace hapton::dds
