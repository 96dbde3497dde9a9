#include "core/collision/visit_stamps.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace hapton {
namespace {

TEST(VisitStamps, EachItemIsNewOnceAQuery) {
  VisitStamps stamps(3);
  for (int query = 0; query < 3; ++query) {
    stamps.start();
    EXPECT_TRUE(stamps.first_visit(1));
    EXPECT_FALSE(stamps.first_visit(1));
    EXPECT_TRUE(stamps.first_visit(2));
    EXPECT_TRUE(stamps.first_visit(0));
    EXPECT_FALSE(stamps.first_visit(2));
  }
}

// Stamps of 8 bits are used up several times; item k is visited only in every k-th query.
TEST(VisitStamps, ForgetsNothingWhenTheStampsAreUsedUp) {
  constexpr std::uint32_t kItems = 300;
  VisitStampsOf<std::uint8_t> stamps(kItems + 1);
  for (std::uint32_t query = 0; query < 1000; ++query) {
    stamps.start();
    for (std::uint32_t item = 1; item <= kItems; ++item) {
      if (query % item != 0) continue;
      ASSERT_TRUE(stamps.first_visit(item)) << item << " in query " << query;
      ASSERT_FALSE(stamps.first_visit(item)) << item << " in query " << query;
    }
  }
}

}  // namespace
}  // namespace hapton
