#include "core/sculpt/field_grid.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(FieldGrid, NumbersNodesAlongXFirst) {
  const FieldGrid grid{.origin_m = Vec3(1.0, 2.0, 3.0), .spacing_m = 0.5, .nodes = {8, 3, 2}};
  EXPECT_EQ(grid.size(), 48U);
  EXPECT_EQ(grid.index(1, 0, 0), 1U);
  EXPECT_EQ(grid.index(0, 1, 0), 8U);
  EXPECT_EQ(grid.index(7, 2, 1), 47U);
  EXPECT_EQ(grid.node(2, 1, 4), Vec3(2.0, 2.5, 5.0));
}

}  // namespace
}  // namespace hapton
