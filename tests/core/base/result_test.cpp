#include "core/base/result.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

Result<int> half(int n) {
  if (n % 2 != 0) return fail("{} is odd; give an even number", n);
  return n / 2;
}

TEST(Result, HoldsAValueOrOneLineOfReason) {
  ASSERT_TRUE(half(4).has_value());
  EXPECT_EQ(*half(4), 2);
  ASSERT_FALSE(half(3).has_value());
  EXPECT_EQ(half(3).error().what, "3 is odd; give an even number");
}

TEST(Result, ChainsToTheFirstFailure) {
  EXPECT_EQ(*half(12).and_then(half), 3);
  EXPECT_EQ(half(6).and_then(half).error().what, "3 is odd; give an even number");
}

}  // namespace
}  // namespace hapton
