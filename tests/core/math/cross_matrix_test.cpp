#include "core/math/cross_matrix.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(CrossMatrix, IsTheCrossProduct) {
  const Vec3 v(1, -2, 3);
  const Vec3 x(0.5, 4, -7);
  EXPECT_EQ(cross_matrix(v) * x, v.cross(x));
  EXPECT_EQ(cross_matrix(v).transpose(), -cross_matrix(v));
}

}  // namespace
}  // namespace hapton
