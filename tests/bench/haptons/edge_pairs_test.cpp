#include "bench/haptons/edge_pairs.h"

#include <gtest/gtest.h>

#include "bench/haptons/extended_pair.h"

namespace hapton {
namespace {

TEST(EdgePairs, CollideOnEdgeAsDeepAsRequested) {
  const EdgePairSettings settings{.seed = 3, .count = 2000};
  double shallowest = 1.0;
  double deepest = 0.0;
  for (const TrianglePair& pair : make_edge_pairs(settings)) {
    const ExtendedContact exact = intersect_extended(pair);
    ASSERT_EQ(exact.count, 2);
    ASSERT_NE(exact.on_edge_of_a[0], exact.on_edge_of_a[1]);
    ASSERT_NEAR(size_of(pair), settings.size_m, 1e-9 * settings.size_m);
    const double length = static_cast<double>((exact.point[1] - exact.point[0]).norm()) / settings.size_m;
    ASSERT_GT(length, 0.999 * settings.shallowest);
    ASSERT_LT(length, 1.001 * settings.deepest);
    shallowest = std::min(shallowest, length);
    deepest = std::max(deepest, length);
  }
  EXPECT_LT(shallowest, 1.1 * settings.shallowest);
  EXPECT_GT(deepest, 0.9 * settings.deepest);
}

TEST(EdgePairs, FollowTheirSeed) {
  const auto one = make_edge_pairs({.seed = 5, .count = 8});
  const auto same = make_edge_pairs({.seed = 5, .count = 8});
  const auto other = make_edge_pairs({.seed = 6, .count = 8});
  EXPECT_EQ(one[7].b[2], same[7].b[2]);
  EXPECT_NE(one[7].b[2], other[7].b[2]);
}

}  // namespace
}  // namespace hapton
