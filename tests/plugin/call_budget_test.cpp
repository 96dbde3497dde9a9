#include "plugin/call_budget.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::int64_t kOver = CallBudget::kDefaultNs + 1;
constexpr std::int64_t kFarOver = CallBudget::kFarNs + 1;

TEST(CallBudget, TheBudgetItselfIsGoodForEver) {
  CallBudget budget;
  for (int n = 0; n < 100000; ++n) ASSERT_TRUE(budget.add(CallBudget::kDefaultNs));
}

TEST(CallBudget, TenOverrunsInARowExhaustItForGood) {
  CallBudget budget;
  for (int n = 0; n < 9; ++n) ASSERT_TRUE(budget.add(kOver)) << n;
  EXPECT_FALSE(budget.add(kOver));
  EXPECT_FALSE(budget.add(0));
}

TEST(CallBudget, OneFarOverrunIsForgivenTwoAreNot) {
  CallBudget once;
  EXPECT_TRUE(once.add(50 * kFarOver)) << "a machine that stands still";
  for (int n = 0; n < 1000; ++n) EXPECT_TRUE(once.add(0));
  EXPECT_TRUE(once.add(kFarOver));
  EXPECT_FALSE(once.add(kFarOver));
}

TEST(CallBudget, OneCallInAHundredMayOverrunNotTwo) {
  CallBudget rare;
  CallBudget often;
  bool is_good = true;
  for (int n = 0; n < 100000; ++n) {
    ASSERT_TRUE(rare.add(n % 102 == 0 ? kOver : 0));
    is_good = often.add(n % 50 == 0 ? kOver : 0);
  }
  EXPECT_FALSE(is_good);
}

}  // namespace
}  // namespace hapton
