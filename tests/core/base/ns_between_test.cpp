#include "core/base/ns_between.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();

TEST(NsBetween, IsTheDifferenceWhere64BitsHoldIt) {
  EXPECT_EQ(ns_between(3, 10), 7);
  EXPECT_EQ(ns_between(10, 3), -7);
  EXPECT_EQ(ns_between(kLast, -1), kFirst);
  EXPECT_EQ(ns_between(-1, kLast - 1), kLast);
  EXPECT_EQ(seconds_between(-500'000'000, 1'000'000'000), 1.5);
}

TEST(NsBetween, EndsAtTheLargestAndTheSmallestNumber) {
  EXPECT_EQ(ns_between(-1, kLast), kLast);
  EXPECT_EQ(ns_between(kFirst, kLast), kLast);
  EXPECT_EQ(ns_between(kFirst, 0), kLast);
  EXPECT_EQ(ns_between(1, kFirst), kFirst);
  EXPECT_EQ(ns_between(kLast, kFirst), kFirst);
}

}  // namespace
}  // namespace hapton
