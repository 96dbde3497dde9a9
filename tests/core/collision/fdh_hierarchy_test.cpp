#include "core/collision/fdh_hierarchy.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

// Rounding outward moves a number by at least half a unit in the last place, even one that is exact in single precision.
TEST(FdhRounding, IsOutwardForEveryMagnitude) {
  std::mt19937_64 random(51);
  std::uniform_real_distribution<double> mantissa(-2.0, 2.0);
  std::uniform_int_distribution<int> exponent(-155, 120);
  for (int i = 0; i < 200000; ++i) {
    double x = std::ldexp(mantissa(random), exponent(random));
    if (i % 3 == 0) x = static_cast<double>(static_cast<float>(x));
    if (i % 1000 == 0) x = 0.0;
    const float below = detail::float_below(x);
    const float above = detail::float_above(x);
    EXPECT_LT(static_cast<double>(below), x);
    EXPECT_GT(static_cast<double>(above), x);
    EXPECT_LE(x - static_cast<double>(below), std::fabs(x) * 0x1p-20 + 0x1p-138);
    EXPECT_LE(static_cast<double>(above) - x, std::fabs(x) * 0x1p-20 + 0x1p-138);
  }
}

TEST(FdhHierarchy, EmptyVisitsNothing) {
  const FdhHierarchy<14> hierarchy;
  FdhInterval<14> everything;
  everything.low.fill(-1e30F);
  everything.high.fill(1e30F);
  int leaves = 0;
  const FdhVisits visits = hierarchy.walk_overlapping(everything, [&](std::uint32_t, std::uint32_t) { ++leaves; });
  EXPECT_EQ(leaves, 0);
  EXPECT_EQ(visits.nodes, 0U);
}

// The first three axes are those of the box. A query that is outside on a single axis, of the box or another one, must be rejected.
TEST(FdhHierarchy, EveryAxisCanRejectAQuery) {
  FdhTopology topology;
  FdhTopology::Children only;
  only.fill(FdhTopology::kNothing);
  only[0] = FdhTopology::leaf(0, 1);
  topology.nodes = {only};
  topology.order = {0};
  topology.depth = 1;
  FdhHierarchy<26> hierarchy;
  hierarchy.adopt(topology);
  hierarchy.refit(0.0, [](std::uint32_t, std::uint32_t) {
    FdhHull<26> unit;
    unit.low.fill(-1.0);
    unit.high.fill(1.0);
    return unit;
  });
  for (int axis = -1; axis < 13; ++axis) {
    FdhInterval<26> query;
    query.low.fill(-0.5F);
    query.high.fill(0.5F);
    if (axis >= 0) {
      query.low[axis] = 1.5F;
      query.high[axis] = 2.0F;
    }
    int leaves = 0;
    hierarchy.walk_overlapping(query, [&](std::uint32_t, std::uint32_t) { ++leaves; });
    EXPECT_EQ(leaves, axis < 0 ? 1 : 0) << "axis " << axis;
  }
}

}  // namespace
}  // namespace hapton
