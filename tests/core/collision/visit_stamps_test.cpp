#include "core/collision/visit_stamps.h"

#include <gtest/gtest.h>

#include <limits>

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

TEST(VisitStamps, ForgetsNothingWhenTheStampRunsOver) {
  VisitStamps stamps(2, std::numeric_limits<std::uint32_t>::max() - 1);
  for (int query = 0; query < 4; ++query) {
    stamps.start();
    EXPECT_TRUE(stamps.first_visit(0)) << query;
    EXPECT_FALSE(stamps.first_visit(0)) << query;
  }
}

}  // namespace
}  // namespace hapton
