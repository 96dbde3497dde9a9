#include "link/rate_limit.h"

#include <gtest/gtest.h>

#include <limits>

#include "link/memory_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(TokenBucketTest, LetsABurstThroughAndThenTheRate) {
  TokenBucket bucket(10, 5);
  int passed = 0;
  for (int i = 0; i < 100; ++i) passed += bucket.take(kSecond) ? 1 : 0;
  EXPECT_EQ(passed, 5);
  passed = 0;
  for (std::int64_t ms = 1; ms <= 10'000; ++ms) passed += bucket.take(kSecond + ms * 1'000'000) ? 1 : 0;
  EXPECT_EQ(passed, 100);
}

TEST(TokenBucketTest, ALongPauseFillsItNoFurther) {
  TokenBucket bucket(10, 5);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(bucket.take(0));
  for (const std::int64_t now_ns : {1000 * kSecond, std::numeric_limits<std::int64_t>::max()}) {
    int passed = 0;
    for (int i = 0; i < 100; ++i) passed += bucket.take(now_ns) ? 1 : 0;
    EXPECT_EQ(passed, 5);
  }
}

TEST(TokenBucketTest, AClockThatGoesBackAddsNoTokens) {
  TokenBucket bucket(10, 1);
  EXPECT_TRUE(bucket.take(100 * kSecond));
  EXPECT_FALSE(bucket.take(0));
  EXPECT_FALSE(bucket.take(100 * kSecond));
  EXPECT_TRUE(bucket.take(101 * kSecond));
}

constexpr SourceLimit::Rates kRates = {.source_per_second = 10, .source_burst = 4, .all_per_second = 100, .all_burst = 20};

TEST(SourceLimitTest, OneSourceIsLimitedWhateverItsPorts) {
  SourceLimit limit(kRates, 1);
  int passed = 0;
  for (std::uint16_t port = 1; port <= 1000; ++port) passed += limit.take(memory_address(2, port), kSecond) ? 1 : 0;
  EXPECT_EQ(passed, 4);
}

TEST(SourceLimitTest, AllTogetherAreLimitedToo) {
  SourceLimit limit(kRates, 1);
  int passed = 0;
  for (int round = 0; round < 4; ++round) {
    for (int host = 1; host <= 200; ++host) passed += limit.take(memory_address(static_cast<std::uint8_t>(host), 9), kSecond) ? 1 : 0;
  }
  EXPECT_EQ(passed, 20);
}

TEST(SourceLimitTest, ASourceThatFloodsLeavesTheOthersTheirShare) {
  SourceLimit limit(kRates, 12345);
  for (int i = 0; i < 1000; ++i) limit.take(memory_address(66, 6), kSecond);
  int passed = 0;
  for (int host = 1; host <= 16; ++host) passed += limit.take(memory_address(static_cast<std::uint8_t>(host), 9), kSecond) ? 1 : 0;
  EXPECT_GE(passed, 14);
}

}  // namespace
}  // namespace hapton
